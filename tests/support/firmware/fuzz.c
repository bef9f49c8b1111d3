/* The firmware on a PC: the same C with registers of plain memory, fed with frames that are half
 * right and half random. Built with sanitizers, which end the program at the first fault.
 *
 * Arguments: number of frames, seed. Prints how many frames came and were answered, and how many
 * commands and pictures there were, of GVCP and of Tables I and II. A run that reaches nothing shows
 * in these counts. */
#include <unistd.h>

#include "machine.h"
#include "mraw.h"

#define PEERS 10		/* of Table I; more than its limit of connections */
#define PEER_PORT 40000

enum tcp_flag { FIN = 1, SYN = 2, RST = 4, PSH = 8, ACK = 16 };

/* What a connection's other side knows of it. */
static struct peer {
	bool open;
	uint32_t port;			/* 0: it has yet to choose one */
	uint32_t next, expected;	/* byte that it sends next, that it awaits */
} peers[PEERS], stray;			/* who is gone, and still gets segments */

static uint32_t answers, clocks;
static uint64_t state;

static uint32_t random32(void)
{
	state = state * 6364136223846793005u + 1442695040888963407u;
	return (uint32_t)(state >> 32);
}

uint32_t reg_read(uint32_t address)
{
	clocks += 2000;
	switch (address) {
	case NCDC_TIME_LOW: return clocks;
	case NCDC_TIME_HIGH: return 0;
	case NCDC_I2C_RESULT:
		return random32() % 64 ? random32() & (0xff | NCDC_I2C_RESULT_BUSY)
				       : NCDC_I2C_RESULT_NACK;
	case NCDC_READER0: case NCDC_READER0 + 4:
	case NCDC_READER0 + 8:
		return (random32() % 256 ? NCDC_READER0_HELD : 0) | (random32() % 4) << NCDC_READER0_BUFFER_SHIFT;
	case LINK_STATUS:
		return random32() & (random32() % 4 ? LINK_STATUS_DONE : LINK_STATUS_DONE |
				     LINK_STATUS_BUSY | LINK_STATUS_RESENDING);
	}
	return machine_read(address);
}

void reg_write(uint32_t address, uint32_t value)
{
	machine_write(address, value);
}

/* Looks at a frame that was sent: where its connection is. */
void sent(const uint8_t *frame, uint32_t size)
{
	const uint8_t *ip = frame + ETH_HEADER, *tcp = ip + IP_HEADER;
	uint32_t port = get16(tcp + 2), k = port % PEERS, flags = tcp[13];

	(void)size;
	++answers;
	if (get16(frame + 12) != ETH_IP || ip[9] != 6 || get16(tcp) != TABLE_PORT)
		return;
	if (port != peers[k].port) {
		stray = (struct peer){!(flags & RST), port, get32(tcp + 8), 0};
		return;
	}
	peers[k].open = !(flags & (RST | FIN));
	if (!peers[k].open)
		peers[k].port = 0;		/* the present one is not free at once */
	if (flags & ACK)
		peers[k].next = get32(tcp + 8);
	peers[k].expected = get32(tcp + 4) + get16(ip + 2) - IP_HEADER - (tcp[12] >> 4) * 4 +
			    !!(flags & (SYN | FIN));
}

/* An address that a command may hit: often one where there is something. */
static uint32_t some_address(void)
{
	static const uint32_t NEAR[] = {
		0, BOOT_FirstUrl, BOOT_ControlPrivilege, BOOT_StreamPort, BOOT_StreamPacketSize,
		BOOT_StreamAddress, BOOT_HeartbeatTimeout, BOOT_Configuration, GVCP_FEATURE_BASE,
		GVCP_FEATURE_BASE + 4 * FEATURE_SensorRegisterAddress, GVCP_XML_BASE,
		GVCP_XML_BASE + 2800, GVCP_CORRECTOR_BASE, GVCP_CORRECTOR_BASE + GVCP_CORRECTOR_BYTES};
	uint32_t base = NEAR[random32() % (sizeof NEAR / sizeof *NEAR)];

	return random32() % 8 ? base + random32() % 32 * 4 : random32();
}

/* The data of a FORCEIP for this device, mostly back to where it was. */
static void force(uint8_t *data)
{
	memset(data, 0, 56);
	memcpy(data + 2, ETH_OWN.bytes, 6);
	put32(data + 20, random32() % 4 ? CONFIG_IP : random32() % 2 ? random32() : 0);
	put32(data + 36, random32() % 4 ? CONFIG_MASK : random32());
}

/* A GVCP command in a frame; its length. */
static uint32_t command(uint8_t *frame)
{
	static const uint8_t CODES[] = {2, 4, 0x40, 0x80, 0x82, 0x84, 0x86, 0x88};
	uint8_t *ip = frame + ETH_HEADER, *udp = ip + IP_HEADER, *data = udp + UDP_HEADER;
	uint32_t code = CODES[random32() % sizeof CODES], size = random32() % 68 * 8;
	bool forces = code == 4 && random32() % 64 == 0;

	if (forces)
		size = 56;

	if (code == 0x84 && random32() % 8)
		size = 8;
	put16(frame + 12, ETH_IP);
	put16(ip, 0x4500);
	put16(ip + 2, IP_HEADER + UDP_HEADER + 8 + size);
	put32(ip + 4, 0);
	put16(ip + 8, 64 << 8 | 17);
	put16(ip + 10, 0);
	put32(ip + 12, CONFIG_IP ^ (1 + random32() % 2));
	put32(ip + 16, !forces && random32() % 4 ? ip_own : 0xffffffff);
	put16(ip + 10, ~ip_sum(ip, IP_HEADER, 0));
	put16(udp, 50000 + random32() % 2);
	put16(udp + 2, random32() % 16 ? GVCP_PORT : random32() & 0xffff);
	put16(udp + 4, UDP_HEADER + 8 + size);
	put16(udp + 6, 0);
	put16(data, 0x4201);
	put16(data + 2, code);
	put16(data + 4, size);
	put16(data + 6, 1 + random32() % 100);
	for (uint32_t k = 0; k < size; k += 4)
		put32(data + 8 + k, k & 4 ? random32() % (random32() % 2 ? 4 : 0x10000)
					  : some_address());
	if (forces)
		force(data + 8);
	if (code == 0x84 && size == 8)
		put32(data + 12, random32() % 640);
	if (code == 0x82 && size >= 32 && random32() % 4 == 0) {
		/* Take control, and have pictures sent: random frames would hardly do so. */
		const uint32_t start[] = {BOOT_ControlPrivilege, 2, BOOT_StreamPort, 5000,
					  BOOT_StreamAddress, get32(ip + 12),
					  GVCP_FEATURE_BASE + 4 * FEATURE_AcquisitionStart, 1};

		for (uint32_t k = 0; k < 8; ++k)
			put32(data + 8 + 4 * k, start[k]);
	}
	return (uint32_t)(data - frame) + 8 + size;
}

/* A frame of TCP, ARP or ICMP with the right addresses, all else random. */
static uint32_t other(uint8_t *frame)
{
	static const uint8_t PROTOCOLS[] = {1, 2, 6, 6, 6, 17};
	uint8_t *ip = frame + ETH_HEADER;
	uint32_t size = 40 + random32() % 600;

	for (uint32_t k = ETH_HEADER; k < ETH_HEADER + size; ++k)
		frame[k] = (uint8_t)random32();
	if (random32() % 4 == 0) {
		put16(frame + 12, ETH_ARP);
		put32(ip, 0x00010800);
		put16(ip + 4, 0x0604);
		put16(ip + 6, 1 + random32() % 2);
		put32(ip + 24, ip_own);
		return ETH_HEADER + size;
	}
	put16(frame + 12, ETH_IP);
	put16(ip, 0x4500);
	put16(ip + 2, random32() % 8 ? size : random32() & 0xffff);
	put16(ip + 6, 0);
	put16(ip + 8, 64 << 8 | PROTOCOLS[random32() % sizeof PROTOCOLS]);
	put32(ip + 12, CONFIG_IP ^ 1);
	put32(ip + 16, ip_own);
	put16(ip + 10, 0);
	put16(ip + 10, ~ip_sum(ip, IP_HEADER, 0));
	put16(ip + 22, random32() % 4 ? TABLE_PORT : random32() & 0xffff);
	return ETH_HEADER + size;
}

/* Ethernet and IPv4 headers before so many bytes for the device; where those begin. */
static uint8_t *ip_header(uint8_t *frame, uint32_t protocol, uint32_t size)
{
	uint8_t *ip = frame + ETH_HEADER;

	put16(frame + 12, ETH_IP);
	put16(ip, 0x4500);
	put16(ip + 2, IP_HEADER + size);
	put32(ip + 4, 0);
	put16(ip + 8, 64 << 8 | protocol);
	put16(ip + 10, 0);
	put32(ip + 12, CONFIG_IP ^ 1);
	put32(ip + 16, ip_own);
	put16(ip + 10, ~ip_sum(ip, IP_HEADER, 0));
	return ip + IP_HEADER;
}

/* A segment of a user of Table I, who mostly keeps TCP's rules; its length. */
static uint32_t user(uint8_t *frame)
{
	static const uint8_t CODES[] = {0x80, 0x81, 0x81, 0x82, 0x83, 0x83, 0x84};
	uint32_t k = random32() % PEERS, size = 0, flags = ACK, segment;
	struct peer *peer = &peers[k];
	bool ends = false;
	uint8_t *tcp = frame + ETH_HEADER + IP_HEADER, *data = tcp + 20;

	if (stray.open) {
		peer = &stray;
		flags = RST;
		ends = true;
	} else if (!peer->open) {
		flags = SYN;
		if (!peer->port) {
			peer->port = PEER_PORT + k + PEERS * (random32() % 1000);
			peer->next = random32();
		}
	} else if (random32() % 4 == 0) {
		flags |= PSH;
		for (uint32_t n = random32() % 8 ? 1 : random32() % 20; n; --n) {
			uint32_t code = CODES[random32() % (random32() % 8 ? 6 : sizeof CODES)];

			data[size++] = (uint8_t)code;
			if (code < 0x82) {
				put16(data + size, random32() % 2 ? 0xf000 + random32() % 24
								  : random32() % 256);
				put16(data + size + 2, random32() % 4 ? random32() % 4 : random32());
				size += 4;
			}
		}
	} else if (random32() % 32 == 0) {
		/* Also what gets a connection going again that a wrong number has stopped. */
		flags |= random32() % 2 ? FIN : RST;
		ends = true;
	}
	segment = 20 + size;
	memset(tcp, 0, 20);
	put16(tcp, peer->port);
	put16(tcp + 2, TABLE_PORT);
	put32(tcp + 4, peer->next + (random32() % 64 ? 0 : random32() % 5000));
	put32(tcp + 8, flags == SYN ? 0 : peer->expected - (random32() % 64 ? 0 : 100));
	put16(tcp + 12, 0x5000 | flags);
	put16(tcp + 14, random32() % 16 ? 0xffff : random32() % 600);
	if (ends)
		*peer = (struct peer){0};
	ip_header(frame, 6, segment);
	put16(tcp + 16, ~ip_sum(tcp, segment, ip_sum(tcp - 8, 8, 6 + segment)));
	return ETH_HEADER + IP_HEADER + segment;
}

/* An answer of ARP, without which TCP's answers wait. */
static uint32_t neighbour(uint8_t *frame)
{
	uint8_t *arp = frame + ETH_HEADER;

	put16(frame + 12, ETH_ARP);
	put32(arp, 0x00010800);
	put32(arp + 4, 0x06040002);
	memcpy(arp + 8, "\x02\0\0\0\0\x01", 6);
	put32(arp + 14, CONFIG_IP ^ 1);
	memcpy(arp + 18, ETH_OWN.bytes, 6);
	put32(arp + 24, ip_own);
	return ETH_HEADER + 28;
}

static uint32_t any(uint8_t *frame)
{
	switch (random32() % 6) {
	case 0: case 1: return command(frame);
	case 2: return other(frame);
	case 3: return random32() % 4 ? user(frame) : neighbour(frame);
	}
	return user(frame);
}

int main(int count, char **arguments)
{
	uint32_t frames = count > 1 ? (uint32_t)strtoul(arguments[1], 0, 10) : 1000;
	uint8_t *frame = (uint8_t *)slot;

	state = count > 2 ? strtoul(arguments[2], 0, 10) : 1;
	/* A loop that stands still is a finding too. */
	alarm(60 + frames / 500);
	machine_begin();
	for (uint32_t k = 0; k < frames; ++k) {
		memset(slot, 0, sizeof slot);
		length = any(frame);
		memcpy(frame, random32() % 8 ? ETH_OWN.bytes : (const uint8_t *)"\xff\xff\xff\xff\xff\xff", 6);
		memcpy(frame + 6, "\x02\0\0\0\0\x01", 6);
		/* One of four frames is damaged: a byte, or its length. */
		if (random32() % 4 == 0)
			frame[random32() % length] = (uint8_t)random32();
		if (random32() % 16 == 0)
			length = random32() % sizeof slot;
		pending = 1;
		if (random32() % 2)
			interrupted();
		machine_turn();
		if (pending) {
			fprintf(stderr, "frame %u stays\n", k);
			return 1;
		}
	}
	printf("%u %u %u %u %u %u %u\n", frames, answers, gvcp_commands, stream_frames,
	       stream_resends, table_commands, mraw_packages);
	return 0;
}
