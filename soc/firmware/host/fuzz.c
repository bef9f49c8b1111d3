/* The firmware on a PC: the same C against registers of plain memory, fed with frames that are half
 * right and half random. Built with sanitizers, which end the program at the first fault.
 *
 * Arguments: number of frames, seed. Prints how many frames came, how many were answered, how many
 * commands and pictures there were: a run that reached nothing would show it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "../eth.h"
#include "../gvcp.h"
#include "../hw.h"
#include "../net.h"
#include "../stream.h"
#include "../table.h"
#include "../uart.h"
#include "../words.h"

#define WORDS 0x20000		/* of each region of registers */

static uint32_t core[WORDS], csr[0x4000], slot[ETHMAC_SLOT_BYTES / 4], out[2 * ETHMAC_SLOT_BYTES / 4];
static uint32_t length, pending, answers, clocks;
static uint64_t state;

static uint32_t random32(void)
{
	state = state * 6364136223846793005u + 1442695040888963407u;
	return (uint32_t)(state >> 32);
}

uint32_t reg_read(uint32_t address)
{
	clocks += 10;
	switch (address) {
	case NCDC_TIME_LOW: return clocks;
	case NCDC_TIME_HIGH: return 0;
	case NCDC_I2C_RESULT: return random32() % 64 ? random32() & 0xff : NCDC_I2C_RESULT_NACK;
	case NCDC_CAMERA_STATUS: return NCDC_CAMERA_STATUS_CORRECTED_FRAME |
					NCDC_CAMERA_STATUS_RAW_FRAME;
	case NCDC_READER0: case NCDC_READER0 + 4:
		return NCDC_READER0_HELD | (random32() % 4) << NCDC_READER0_BUFFER_SHIFT;
	case LINK_STATUS: return random32() & LINK_STATUS_DONE;
	case CSR_ETHMAC_SRAM_WRITER_EV_PENDING: return pending;
	case CSR_ETHMAC_SRAM_WRITER_LENGTH: return length;
	case CSR_ETHMAC_SRAM_WRITER_SLOT: return 0;
	case CSR_ETHMAC_SRAM_READER_READY: return 1;
	case CSR_ETHMAC_SRAM_READER_LEVEL: return 0;
	case CSR_UART_TXFULL: return 0;
	}
	if (address - ETHMAC_RX_BASE < sizeof slot)
		return slot[(address - ETHMAC_RX_BASE) / 4];
	if (address - NCDC_BASE < sizeof core)
		return core[(address - NCDC_BASE) / 4];
	if (address - CSR_CTRL_RESET < sizeof csr)
		return csr[(address - CSR_CTRL_RESET) / 4];
	fprintf(stderr, "nothing to read at %#x\n", address);
	abort();
}

void reg_write(uint32_t address, uint32_t value)
{
	if (address % 4) {
		fprintf(stderr, "%#x is no word\n", address);
		abort();
	}
	if (address == CSR_ETHMAC_SRAM_WRITER_EV_PENDING)
		pending = 0;
	else if (address == CSR_ETHMAC_SRAM_READER_START)
		++answers;
	else if (address - ETHMAC_TX_BASE < sizeof out)
		out[(address - ETHMAC_TX_BASE) / 4] = value;
	else if (address - NCDC_BASE < sizeof core)
		core[(address - NCDC_BASE) / 4] = value;
	else if (address - CSR_CTRL_RESET < sizeof csr)
		csr[(address - CSR_CTRL_RESET) / 4] = value;
	else {
		fprintf(stderr, "nothing to write at %#x\n", address);
		abort();
	}
}

/* An address that a command may hit: often one where there is something. */
static uint32_t some_address(void)
{
	static const uint32_t NEAR[] = {
		0, BOOT_FirstUrl, BOOT_ControlPrivilege, BOOT_StreamPort, BOOT_StreamPacketSize,
		BOOT_StreamAddress, BOOT_HeartbeatTimeout, GVCP_FEATURE_BASE, GVCP_XML_BASE,
		GVCP_XML_BASE + 2800, GVCP_CORRECTOR_BASE, GVCP_CORRECTOR_BASE + GVCP_CORRECTOR_BYTES};
	uint32_t base = NEAR[random32() % (sizeof NEAR / sizeof *NEAR)];

	return random32() % 8 ? base + random32() % 32 * 4 : random32();
}

/* A GVCP command in a frame; its length. */
static uint32_t command(uint8_t *frame)
{
	static const uint8_t CODES[] = {2, 4, 0x40, 0x80, 0x82, 0x84, 0x86, 0x88};
	uint8_t *ip = frame + ETH_HEADER, *udp = ip + IP_HEADER, *data = udp + UDP_HEADER;
	uint32_t code = CODES[random32() % sizeof CODES], size = random32() % 68 * 8;

	if (code == 0x84 && random32() % 8)
		size = 8;
	put16(frame + 12, ETH_IP);
	put16(ip, 0x4500);
	put16(ip + 2, IP_HEADER + UDP_HEADER + 8 + size);
	put32(ip + 4, 0);
	put16(ip + 8, 64 << 8 | 17);
	put16(ip + 10, 0);
	put32(ip + 12, CONFIG_IP ^ (1 + random32() % 2));
	put32(ip + 16, random32() % 4 ? CONFIG_IP : 0xffffffff);
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
	if (code == 0x84 && size == 8)
		put32(data + 12, random32() % 640);
	if (code == 0x82 && size >= 32 && random32() % 4 == 0) {
		/* Take control, and have pictures sent: chance alone would hardly do so. */
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
		put32(ip + 24, CONFIG_IP);
		return ETH_HEADER + size;
	}
	put16(frame + 12, ETH_IP);
	put16(ip, 0x4500);
	put16(ip + 2, random32() % 8 ? size : random32() & 0xffff);
	put16(ip + 6, 0);
	put16(ip + 8, 64 << 8 | PROTOCOLS[random32() % sizeof PROTOCOLS]);
	put32(ip + 12, CONFIG_IP ^ 1);
	put32(ip + 16, CONFIG_IP);
	put16(ip + 10, 0);
	put16(ip + 10, ~ip_sum(ip, IP_HEADER, 0));
	put16(ip + 22, random32() % 4 ? TABLE_PORT : random32() & 0xffff);
	return ETH_HEADER + size;
}

int main(int count, char **arguments)
{
	uint32_t frames = count > 1 ? (uint32_t)strtoul(arguments[1], 0, 10) : 1000;
	uint8_t *frame = (uint8_t *)slot;

	state = count > 2 ? strtoul(arguments[2], 0, 10) : 1;
	words_begin();
	gvcp_begin();
	net_begin();
	for (uint32_t k = 0; k < frames; ++k) {
		memset(slot, 0, sizeof slot);
		length = random32() % 3 ? command(frame) : other(frame);
		memcpy(frame, random32() % 8 ? ETH_OWN.bytes : (const uint8_t *)"\xff\xff\xff\xff\xff\xff", 6);
		memcpy(frame + 6, "\x02\0\0\0\0\x01", 6);
		/* One of four frames is damaged: a byte, or its length. */
		if (random32() % 4 == 0)
			frame[random32() % length] = (uint8_t)random32();
		if (random32() % 16 == 0)
			length = random32() % sizeof slot;
		pending = 1;
		net_poll();
		stream_poll();
		gvcp_poll();
		if (pending) {
			fprintf(stderr, "frame %u stays\n", k);
			return 1;
		}
	}
	printf("%u %u %u %u %u\n", frames, answers, gvcp_commands, stream_frames, stream_resends);
	return 0;
}
