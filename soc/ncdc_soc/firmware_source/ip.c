#include "ip.h"

#include <string.h>

#include "hw.h"

#define VERSION 0x4500		/* 4, and a header of five words */
#define HOPS 64
#define UDP 17
#define DO_NOT_FRAGMENT 0x4000
#define FRAGMENT 0x3fff		/* offset, and more to come */

typedef uint16_t __attribute__((may_alias)) half;

_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "half words are read swapped");

uint32_t ip_own, ip_mask;

/* The sum of half words as the processor reads them, which is the sum of swapped ones. It adds two at
 * a time, and 64 kB do not carry out of 32 bits. */
static uint32_t swapped_sum(const uint8_t *bytes, uint32_t length)
{
	const half *halves = (const half *)(const void *)bytes;
	uint32_t swapped = 0;

	for (; length > 3; length -= 4, halves += 2)
		swapped += (uint32_t)halves[0] + halves[1];
	if (length > 1) {
		swapped += *halves++;
		length -= 2;
	}
	if (length)
		swapped += *(const uint8_t *)halves;
	return swapped;
}

static uint32_t folded(uint32_t sum)
{
	while (sum >> 16)
		sum = (sum & 0xffff) + (sum >> 16);
	return sum;
}

uint32_t ip_sum(const uint8_t *bytes, uint32_t length, uint32_t sum)
{
	uint32_t swapped = folded(swapped_sum(bytes, length));

	/* The sum of swapped bytes is the swapped sum. */
	return folded(sum + ((swapped & 0xff) << 8 | swapped >> 8));
}

uint8_t *udp_header(uint8_t *frame, const struct udp_path *to, uint32_t length)
{
	uint8_t *ip = frame + ETH_HEADER, *udp = ip + IP_HEADER;
	uint32_t total = IP_HEADER + UDP_HEADER + length;

	memcpy(frame, to->mac.bytes, 6);
	memcpy(frame + 6, ETH_OWN.bytes, 6);
	put16(frame + 12, ETH_IP);
	put16(ip, VERSION);
	put16(ip + 2, total);
	put16(ip + 4, 0);
	put16(ip + 6, DO_NOT_FRAGMENT);
	put16(ip + 8, HOPS << 8 | UDP);
	put16(ip + 10, ~folded(VERSION + total + DO_NOT_FRAGMENT + (HOPS << 8 | UDP) +
			       (ip_own >> 16) + (ip_own & 0xffff) + (to->ip >> 16) +
			       (to->ip & 0xffff)));
	put32(ip + 12, ip_own);
	put32(ip + 16, to->ip);
	put16(udp, to->own_port);
	put16(udp + 2, to->port);
	put16(udp + 4, UDP_HEADER + length);
	put16(udp + 6, 0);
	return udp + UDP_HEADER;
}

bool udp_parse(const uint8_t *frame, uint32_t length, struct datagram *datagram)
{
	const uint8_t *ip = frame + ETH_HEADER, *udp = ip + IP_HEADER;
	uint32_t total, size, to;

	if (length < ETH_HEADER + IP_HEADER + UDP_HEADER || get16(frame + 12) != ETH_IP)
		return false;
	total = get16(ip + 2);
	if (ip[0] != 0x45 || ip[9] != UDP || get16(ip + 6) & FRAGMENT ||
	    total > length - ETH_HEADER || total < IP_HEADER + UDP_HEADER ||
	    folded(swapped_sum(ip, IP_HEADER)) != 0xffff)
		return false;
	to = get32(ip + 16);
	if (to != ip_own && to != 0xffffffff && to != (ip_own | ~ip_mask))
		return false;
	size = get16(udp + 4);
	if (size < UDP_HEADER || size > total - IP_HEADER)
		return false;
	/* With the sum of a pseudo header: addresses, protocol, length. Swapped, all ones are ones. */
	if (get16(udp + 6) &&
	    folded(swapped_sum(udp, size) + swapped_sum(ip + 12, 8) + (UDP << 8) +
		   ((size & 0xff) << 8 | size >> 8)) != 0xffff)
		return false;
	memcpy(datagram->from.mac.bytes, frame + 6, 6);
	datagram->from.ip = get32(ip + 12);
	datagram->from.port = get16(udp);
	datagram->from.own_port = datagram->port = get16(udp + 2);
	datagram->data = udp + UDP_HEADER;
	datagram->length = size - UDP_HEADER;
	return true;
}
