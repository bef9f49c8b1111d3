#include "net.h"

#include <string.h>

#include "eth.h"
#include "gvcp.h"
#include "hw.h"
#include "ip.h"
#include "uart.h"

#define ARP_BYTES 42

static uint32_t words[(ETH_LONGEST + 3) / 4];

void net_begin(void)
{
	ip_own = CONFIG_IP;
	ip_mask = CONFIG_MASK;
	uart_text("address: ");
	uart_hex(ip_own);
	uart_text("\n");
}

/* Answers who asks for this device's address. */
static void arp(uint8_t *frame, uint32_t length)
{
	uint8_t *p = frame + ETH_HEADER;

	if (length < ARP_BYTES || get16(p) != 1 || get16(p + 2) != ETH_IP ||
	    get16(p + 4) != 0x0604 || get16(p + 6) != 1 || get32(p + 24) != ip_own)
		return;
	memcpy(frame, frame + 6, 6);
	memcpy(frame + 6, ETH_OWN.bytes, 6);
	put16(p + 6, 2);
	memmove(p + 18, p + 8, 10);
	memcpy(p + 8, ETH_OWN.bytes, 6);
	put32(p + 14, ip_own);
	eth_send(frame, ARP_BYTES);
}

void net_poll(void)
{
	uint8_t *frame = (uint8_t *)words;
	uint32_t length = eth_receive(frame);

	if (length < ETH_HEADER)
		return;
	if (get16(frame + 12) == ETH_ARP)
		arp(frame, length);
	else
		gvcp_frame(frame, length);
}
