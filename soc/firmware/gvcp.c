#include "gvcp.h"

#include "gvcp_control.h"
#include "hw.h"
#include "stream.h"

enum {
	DISCOVERY = 0x02, PACKETRESEND = 0x40, READREG = 0x80, WRITEREG = 0x82, READMEM = 0x84,
	WRITEMEM = 0x86
};

#define KEY 0x42
#define HEADER 8
#define ANSWER 1			/* flag: the sender wants an acknowledge */
#define MEMORY_MAX 536
#define REGISTERS_MAX 135

uint32_t gvcp_commands;

static uint32_t answer_words[(ETH_HEADER + IP_HEADER + UDP_HEADER + HEADER + 4 + MEMORY_MAX + 7) / 4];

/* Commands: each takes its data, writes those of its answer, and gives a status. */

static uint32_t read_registers(const uint8_t *data, uint32_t length, uint8_t *to, uint32_t *size)
{
	if (!length || length % 4 || length > 4 * REGISTERS_MAX)
		return INVALID_HEADER;
	for (uint32_t k = 0; k < length; k += 4) {
		uint32_t value = 0, status = gvcp_read_word(get32(data + k), &value);

		if (status)
			return status;
		put32(to + k, value);
	}
	*size = length;
	return SUCCESS;
}

static uint32_t write_registers(const uint8_t *data, uint32_t length, const struct udp_path *peer,
				uint8_t *to, uint32_t *size)
{
	if (!length || length % 8 || length > 4 * REGISTERS_MAX)
		return INVALID_HEADER;
	for (uint32_t k = 0; k < length; k += 8) {
		uint32_t status = gvcp_write_word(get32(data + k), get32(data + k + 4), peer);

		if (status)
			return status;
	}
	put32(to, length / 8);
	*size = 4;
	return SUCCESS;
}

static uint32_t read_block(const uint8_t *data, uint32_t length, uint8_t *to, uint32_t *size)
{
	uint32_t count, status;

	if (length != 8)
		return INVALID_HEADER;
	count = get16(data + 6);
	if (count < 4 || count > MEMORY_MAX)
		return INVALID_PARAMETER;
	if (count % 4)
		return BAD_ALIGNMENT;
	put32(to, get32(data));
	status = gvcp_read_memory(get32(data), count, to + 4);
	*size = 4 + count;
	return status;
}

static uint32_t write_block(const uint8_t *data, uint32_t length, const struct udp_path *peer,
			    uint8_t *to, uint32_t *size)
{
	if (length < 8 || length > 4 + MEMORY_MAX || length % 4)
		return INVALID_HEADER;
	for (uint32_t k = 4; k < length; k += 4) {
		uint32_t status = gvcp_write_word(get32(data) + k - 4, get32(data + k), peer);

		if (status)
			return status;
	}
	put32(to, length - 4);
	*size = 4;
	return SUCCESS;
}

static void send_again(const uint8_t *data, uint32_t length, const struct udp_path *peer)
{
	/* A receiver asks from a port of its own, perhaps, but from the controller's machine. */
	if (length < 12 || !control.controlled || peer->ip != control.controller.ip)
		return;
	stream_resend(get16(data + 2), get32(data + 4) & 0xffffff, get32(data + 8) & 0xffffff);
}

static uint32_t carry_out(uint32_t code, const uint8_t *data, uint32_t length,
			  const struct udp_path *peer, uint8_t *to, uint32_t *size)
{
	switch (code) {
	case DISCOVERY:
		*size = GVCP_DISCOVERY_BYTES;
		return gvcp_read_memory(0, GVCP_DISCOVERY_BYTES, to);
	case READREG: return read_registers(data, length, to, size);
	case WRITEREG: return write_registers(data, length, peer, to, size);
	case READMEM: return read_block(data, length, to, size);
	case WRITEMEM: return write_block(data, length, peer, to, size);
	}
	return NOT_IMPLEMENTED;
}

bool gvcp_frame(const uint8_t *frame, uint32_t length)
{
	struct datagram datagram;
	uint8_t *answer = (uint8_t *)answer_words + ETH_HEADER + IP_HEADER + UDP_HEADER;
	const uint8_t *data;
	uint32_t code, request, size = 0, status;

	if (!udp_parse(frame, length, &datagram) || datagram.port != GVCP_PORT)
		return false;
	data = datagram.data;
	if (datagram.length < HEADER || data[0] != KEY || get16(data + 4) != datagram.length - HEADER)
		return true;
	code = get16(data + 2);
	request = get16(data + 6);
	if (!request || code & 1)
		return true;
	++gvcp_commands;
	if (control_is(&datagram.from))
		control.heard = now64();
	if (code == PACKETRESEND) {
		send_again(data + HEADER, datagram.length - HEADER, &datagram.from);
		return true;
	}
	status = carry_out(code, data + HEADER, datagram.length - HEADER, &datagram.from,
			   answer + HEADER, &size);
	if (!(data[1] & ANSWER))
		return true;
	if (status)
		size = 0;
	put16(answer, status);
	put16(answer + 2, code + 1);
	put16(answer + 4, size);
	put16(answer + 6, request);
	udp_header((uint8_t *)answer_words, &datagram.from, HEADER + size);
	eth_send(answer_words, ETH_HEADER + IP_HEADER + UDP_HEADER + HEADER + size);
	return true;
}
