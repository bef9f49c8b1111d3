#include "net.h"

#include <stdbool.h>
#include <string.h>

#include "eth.h"
#include "gvcp.h"
#include "hw.h"
#include "ip.h"
#include "lwip/autoip.h"
#include "lwip/dhcp.h"
#include "lwip/etharp.h"
#include "lwip/init.h"
#include "lwip/timeouts.h"
#include "table.h"
#include "uart.h"

#define TIMERS_CLOCKS (10 * MILLISECOND_CLOCKS)

static struct netif interface;
static uint32_t words[(ETH_LONGEST + 3) / 4];
static uint32_t random_state = 1;
static uint32_t looked;		/* clock at which lwIP's timers were looked at */
static bool seeks;		/* an address is to be looked for anew */

/* What lwIP asks of its surroundings. */

uint32_t sys_now(void)
{
	static uint32_t milliseconds, counted;		/* and the clock up to which they are */

	/* It is asked a hundred times a second; a division of 64 bits costs more than this. */
	for (; now32() - counted >= MILLISECOND_CLOCKS; counted += MILLISECOND_CLOCKS)
		++milliseconds;
	return milliseconds;
}

uint32_t lwip_random(void)
{
	/* Clocks of packets that come are the noise. */
	random_state = (random_state ^ now32()) * 1664525u + 1013904223u;
	return random_state;
}

void lwip_failed(void)
{
	uart_text("lwIP has failed\n");
	for (;;)
		;
}

static err_t send(struct netif *netif, struct pbuf *chain)
{
	static uint32_t frame[(ETH_LONGEST + 3) / 4];

	(void)netif;
	if (chain->tot_len > ETH_LONGEST)
		return ERR_BUF;
	pbuf_copy_partial(chain, frame, chain->tot_len, 0);
	eth_send(frame, chain->tot_len);
	return ERR_OK;
}

static void changed(struct netif *netif)
{
	ip_own = lwip_ntohl(netif_ip4_addr(netif)->addr);
	ip_mask = lwip_ntohl(netif_ip4_netmask(netif)->addr);
	uart_text("address: ");
	uart_hex(ip_own);
	uart_text("\n");
}

static err_t begin(struct netif *netif)
{
	netif->name[0] = 'e';
	netif->name[1] = '0';
	netif->mtu = 1500;
	netif->hwaddr_len = 6;
	memcpy(netif->hwaddr, ETH_OWN.bytes, 6);
	netif->flags = NETIF_FLAG_BROADCAST | NETIF_FLAG_ETHARP | NETIF_FLAG_LINK_UP;
	netif->output = etharp_output;
	netif->linkoutput = send;
	return ERR_OK;
}

/* Without an address of its own the device asks for one, and takes a link-local one if no server
 * answers. */
static void seek(void)
{
	if (dhcp_start(&interface) != ERR_OK)
		uart_text("DHCP: no memory\n");
}

static void set_address(uint32_t ip, uint32_t mask, uint32_t gateway)
{
	ip4_addr_t addresses[] = {{lwip_htonl(ip)}, {lwip_htonl(mask)}, {lwip_htonl(gateway)}};

	netif_set_addr(&interface, &addresses[0], &addresses[1], &addresses[2]);
}

bool net_force(uint32_t ip, uint32_t mask, uint32_t gateway)
{
	uint32_t hosts = ~mask;

	seeks = !ip;
	if (seeks)
		return true;
	/* Ones that end, then zeros; a host's number of neither zeros nor ones; no multicast. */
	if (!mask || hosts & (hosts + 1) || !(ip & hosts) || (ip & hosts) == hosts ||
	    ip >> 28 >= 14 || ip >> 24 == 0 || ip >> 24 == 127)
		return false;
	dhcp_stop(&interface);
	autoip_stop(&interface);
	set_address(ip, mask, gateway);
	return true;
}

void net_begin(void)
{
	lwip_init();
	netif_add(&interface, 0, 0, 0, 0, begin, netif_input);
	netif_set_default(&interface);
	netif_set_status_callback(&interface, changed);
	netif_set_up(&interface);
	if (CONFIG_IP)
		set_address(CONFIG_IP, CONFIG_MASK, 0);
	else
		seek();
	if (table_begin())
		uart_text("Table I: no memory\n");
}

void net_poll(void)
{
	const uint8_t *frame = (const uint8_t *)words;
	uint32_t length = eth_receive(words);
	struct pbuf *buffer;

	if (seeks) {
		seeks = false;
		set_address(0, 0, 0);
		seek();
	}
	/* Looking at lwIP's timers takes longer than the loop can afford each time. */
	if (now32() - looked >= TIMERS_CLOCKS) {
		looked = now32();
		sys_check_timeouts();
	}
	if (length < ETH_HEADER || gvcp_frame(frame, length))
		return;
	buffer = pbuf_alloc(PBUF_RAW, (uint16_t)length, PBUF_POOL);
	if (!buffer)
		return;
	pbuf_take(buffer, frame, (uint16_t)length);
	if (interface.input(buffer, &interface) != ERR_OK)
		pbuf_free(buffer);
}
