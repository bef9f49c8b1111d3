/* Ethernet frames of the processor's own, in the MAC's memory. */
#ifndef ETH_H
#define ETH_H

#include <stdint.h>

#define ETH_LONGEST 1514	/* bytes of a frame without its check sequence */
#define ETH_HEADER 14
#define ETH_IP 0x0800
#define ETH_ARP 0x0806

struct eth_address {
	uint8_t bytes[6];
};

extern const struct eth_address ETH_OWN;
extern uint32_t eth_received, eth_sent, eth_dropped;

/* The next frame, copied to `frame` of ETH_LONGEST bytes, rounded up to a word; its length, or 0. */
uint32_t eth_receive(uint32_t *frame);

/* Sends a frame of `length` bytes. */
void eth_send(const uint32_t *frame, uint32_t length);

#endif
