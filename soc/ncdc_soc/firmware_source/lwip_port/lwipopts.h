/* lwIP in one loop: no threads, its callback interface, IPv4 on the local link. */
#ifndef LWIPOPTS_H
#define LWIPOPTS_H

#define NO_SYS 1
#define SYS_LIGHTWEIGHT_PROT 0
#define LWIP_NETCONN 0
#define LWIP_SOCKET 0
#define LWIP_IPV6 0
#define LWIP_DNS 0
#define LWIP_IGMP 0
#define LWIP_RAW 0
#define LWIP_STATS 0
#define IP_REASSEMBLY 0
#define IP_FRAG 0
#define LWIP_DHCP 1
#define LWIP_AUTOIP 1
#define LWIP_DHCP_AUTOIP_COOP 1
#define LWIP_DHCP_AUTOIP_COOP_TRIES 2
#define LWIP_ACD 0
#define LWIP_NETIF_STATUS_CALLBACK 1
#ifdef FIRMWARE_HOST
#define MEM_ALIGNMENT 8
#else
#define MEM_ALIGNMENT 4
#endif
#define MEM_SIZE (28 * 1024)	/* three segments under way to each user */
#define HALF_OPEN 4		/* connections that only one side has begun */
#define MEMP_NUM_TCP_PCB (TABLE_USERS + HALF_OPEN + 2)	/* users, and one that is rejected */
#define MEMP_NUM_TCP_SEG 32
#define MEMP_NUM_PBUF 16
#define PBUF_POOL_SIZE 8
#define PBUF_POOL_BUFSIZE 1536
#define TCP_MSS 1460
#define TCP_WND (2 * TCP_MSS)
#define TCP_SND_BUF (4 * TCP_MSS)
#define TCP_SND_QUEUELEN 12
#define TCP_OVERSIZE 256
#define TCP_QUEUE_OOSEQ 0	/* requests are short: one that is lost comes again with the next */
#define LWIP_NETIF_TX_SINGLE_PBUF 1
#define LWIP_TCP_KEEPALIVE 1
/* A connection whose client has vanished is freed in two minutes. */
#define TCP_KEEPIDLE_DEFAULT 60000UL
#define TCP_KEEPINTVL_DEFAULT 10000UL
#define TCP_KEEPCNT_DEFAULT 6U

#include "config.h"

/* Before lwIP answers who begins a connection. */
struct tcp_pcb;
signed char table_incoming(struct tcp_pcb *pcb, unsigned flags);
#define LWIP_HOOK_TCP_INPACKET_PCB(pcb, header, length, first, second, rest) \
	table_incoming(pcb, TCPH_FLAGS(header))

#endif
