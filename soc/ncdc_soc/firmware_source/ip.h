/* Headers of IP and UDP. */
#ifndef IP_H
#define IP_H

#include <stdbool.h>
#include <stdint.h>

#include "eth.h"

#define IP_HEADER 20
#define UDP_HEADER 8

extern uint32_t ip_own;		/* 0: none yet */
extern uint32_t ip_mask;

struct udp_path {
	struct eth_address mac;	/* who receives */
	uint32_t ip, port;
	uint32_t own_port;
};

/* A datagram in a frame that was received. */
struct datagram {
	struct udp_path from;
	uint32_t port;		/* that it is for */
	const uint8_t *data;
	uint32_t length;
};

/* Check sum of up to 64 kB at an even address, added to `sum`; an odd last byte counts as the upper
 * one. */
uint32_t ip_sum(const uint8_t *bytes, uint32_t length, uint32_t sum);

/* Writes Ethernet, IP and UDP headers before so many bytes; where those begin. UDP's check sum is
 * 0: none. */
uint8_t *udp_header(uint8_t *frame, const struct udp_path *to, uint32_t length);

/* Takes a frame apart; false if it is no whole, unfragmented UDP datagram for this device. */
bool udp_parse(const uint8_t *frame, uint32_t length, struct datagram *datagram);

#endif
