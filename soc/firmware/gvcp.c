#include "gvcp.h"

#include <string.h>

#include "hw.h"
#include "stream.h"
#include "words.h"

enum {
	DISCOVERY = 0x02, PACKETRESEND = 0x40, READREG = 0x80, WRITEREG = 0x82, READMEM = 0x84,
	WRITEMEM = 0x86
};
enum {
	SUCCESS = 0, NOT_IMPLEMENTED = 0x8001, INVALID_PARAMETER = 0x8002,
	INVALID_ADDRESS = 0x8003, WRITE_PROTECT = 0x8004, BAD_ALIGNMENT = 0x8005,
	ACCESS_DENIED = 0x8006, INVALID_HEADER = 0x800e, DEVICE_ERROR = 0x8ffe
};

#define KEY 0x42
#define HEADER 8
#define ANSWER 1			/* flag: the sender wants an acknowledge */
#define MEMORY_MAX 536
#define REGISTERS_MAX 135
#define FIRE (1u << 31)
#define PORTS_MAX 0xffffu
#define HEARTBEAT_LEAST 500u
#define PACKET_LEAST 576u
#define PACKET_MOST 16380u
#define DELAY_MOST 1000000u		/* ns */

uint32_t gvcp_commands;

static const uint8_t XML[] = CONFIG_XML;

struct text {
	uint32_t address, length;
	const char *text;
};

static const struct text TEXTS[] = CONFIG_TEXTS;

/* Registers that a controller writes. */
static uint32_t heartbeat = HEARTBEAT_MS, privilege, stream_port, stream_delay, stream_address;
static uint32_t packet_size, tl_locked, single, sensor_address;
static uint64_t stamp;
static bool acquiring;

static struct udp_path controller;	/* while `controlled` */
static bool controlled;
static uint64_t heard;

static uint32_t answer_words[(ETH_HEADER + IP_HEADER + UDP_HEADER + HEADER + 4 + MEMORY_MAX + 7) / 4];

static bool same(const struct udp_path *a, const struct udp_path *b)
{
	return a->ip == b->ip && a->port == b->port;
}

static void release(void)
{
	stream_stop();
	controlled = acquiring = false;
	heartbeat = HEARTBEAT_MS;
	privilege = stream_port = stream_delay = stream_address = tl_locked = single = 0;
	packet_size = PACKET_DO_NOT_FRAGMENT | stream_packet_size(1500);
	words_streaming = false;
}

void gvcp_begin(void)
{
	release();
}

void gvcp_poll(void)
{
	/* A stream of one picture ends by itself; its packets can still be sent again. */
	if (acquiring && stream_ended()) {
		acquiring = false;
		words_streaming = tl_locked;
	}
	if (controlled && now64() - heard > (uint64_t)heartbeat * (CLOCK_HZ / 1000))
		release();
}

/* Reading. */

static uint32_t text_word(const struct text *text, uint32_t offset)
{
	uint8_t bytes[4] = {0};
	uint32_t length = (uint32_t)strlen(text->text);

	for (uint32_t k = 0; k < 4 && offset + k < length; ++k)
		bytes[k] = (uint8_t)text->text[offset + k];
	return get32(bytes);
}

static uint32_t own_feature(const struct feature *one)
{
	switch (one->id) {
	case FEATURE_PayloadSize: return words_view().bytes;
	case FEATURE_AcquisitionMode: return single;
	case FEATURE_TLParamsLocked: return tl_locked;
	case FEATURE_SensorRegisterAddress: return sensor_address;
	case FEATURE_SensorRegisterValue: return word_read(sensor_address);
	}
	return 0;
}

static bool bootstrap(uint32_t address, uint32_t *value)
{
	switch (address) {
	case BOOT_Version: *value = 0x00010002; return true;
	case BOOT_DeviceMode: *value = 0x80000001; return true;
	case BOOT_MacHigh: *value = get16(ETH_OWN.bytes); return true;
	case BOOT_MacLow: *value = get32(ETH_OWN.bytes + 2); return true;
	case BOOT_IpOptions: *value = 6; return true;
	case BOOT_IpConfiguration: *value = 4; return true;
	case BOOT_IpAddress: *value = ip_own; return true;
	case BOOT_SubnetMask: *value = ip_mask; return true;
	case BOOT_NetworkInterfaces: case BOOT_StreamChannels: *value = 1; return true;
	case BOOT_Gateway: case BOOT_MessageChannels: case BOOT_TickFrequencyHigh:
	case BOOT_TimestampControl: *value = 0; return true;
	case BOOT_Capability: *value = GVCP_CAPABILITY; return true;
	case BOOT_HeartbeatTimeout: *value = heartbeat; return true;
	case BOOT_TickFrequencyLow: *value = 1000000000; return true;
	case BOOT_TimestampHigh: *value = (uint32_t)(stamp >> 32); return true;
	case BOOT_TimestampLow: *value = (uint32_t)stamp; return true;
	case BOOT_ControlPrivilege: *value = privilege; return true;
	case BOOT_StreamPort: *value = stream_port; return true;
	case BOOT_StreamPacketSize: *value = packet_size; return true;
	case BOOT_StreamPacketDelay: *value = stream_delay; return true;
	case BOOT_StreamAddress: *value = stream_address; return true;
	case BOOT_StreamSourcePort: *value = STREAM_PORT; return true;
	}
	*value = 0;		/* reserved words of the discovery acknowledge */
	return address < GVCP_DISCOVERY_BYTES;
}

/* The word at an address; a status. */
static uint32_t read_word(uint32_t address, uint32_t *value)
{
	const struct feature *one;

	if (address % 4)
		return BAD_ALIGNMENT;
	if (address - GVCP_XML_BASE < (sizeof XML + 3) / 4 * 4) {
		uint8_t bytes[4] = {0};
		uint32_t at = address - GVCP_XML_BASE;

		for (uint32_t k = 0; k < 4 && at + k < sizeof XML; ++k)
			bytes[k] = XML[at + k];
		*value = get32(bytes);
		return SUCCESS;
	}
	if (address - GVCP_CORRECTOR_BASE < GVCP_CORRECTOR_BYTES) {
		*value = reg_read(NCDC_BASE + (address - GVCP_CORRECTOR_BASE));
		return SUCCESS;
	}
	one = address >= GVCP_FEATURE_BASE ? feature_at(address) : 0;
	if (one) {
		*value = one->lower == NO_WORD ? own_feature(one) : feature_read(one);
		return SUCCESS;
	}
	for (unsigned k = 0; k < sizeof TEXTS / sizeof *TEXTS; ++k)
		if (address - TEXTS[k].address < TEXTS[k].length) {
			*value = text_word(&TEXTS[k], address - TEXTS[k].address);
			return SUCCESS;
		}
	return bootstrap(address, value) ? SUCCESS : INVALID_ADDRESS;
}

/* Writes `count` bytes of `size` that begin at `from`, and zeros behind their end. */
static void copy(uint8_t *to, uint32_t count, const void *from, uint32_t size, uint32_t at)
{
	uint32_t there = at < size ? size - at : 0;

	if (there > count)
		there = count;
	memcpy(to, (const uint8_t *)from + (there ? at : 0), there);
	memset(to + there, 0, count - there);
}

/* Writes bytes from an address on; a status. Long texts go as a whole: word by word they would keep
 * a client waiting. */
static uint32_t read_memory(uint32_t address, uint32_t count, uint8_t *to)
{
	if (address % 4)
		return BAD_ALIGNMENT;
	/* A client may read beyond the XML's end to fill its last packet. */
	if (address - GVCP_XML_BASE < sizeof XML) {
		copy(to, count, XML, sizeof XML, address - GVCP_XML_BASE);
		return SUCCESS;
	}
	for (unsigned k = 0; k < sizeof TEXTS / sizeof *TEXTS; ++k) {
		uint32_t at = address - TEXTS[k].address;

		if (at < TEXTS[k].length && count <= TEXTS[k].length - at) {
			copy(to, count, TEXTS[k].text, (uint32_t)strlen(TEXTS[k].text), at);
			return SUCCESS;
		}
	}
	for (uint32_t k = 0; k < count; k += 4) {
		uint32_t value = 0, status = read_word(address + k, &value);

		if (status)
			return status;
		put32(to + k, value);
	}
	return SUCCESS;
}

/* Writing. */

static bool receiver(struct receiver *to)
{
	if (!stream_port || !stream_address)
		return false;
	to->ip = stream_address;
	to->port = stream_port;
	to->packet_size = packet_size & 0xffff;
	to->delay_clocks = stream_delay / (1000000000u / CLOCK_HZ);
	if (stream_address >> 28 == 14) {		/* a multicast group */
		uint8_t mac[6] = {0x01, 0x00, 0x5e, stream_address >> 16 & 0x7f,
				  stream_address >> 8 & 0xff, stream_address & 0xff};

		memcpy(to->mac.bytes, mac, 6);
		return true;
	}
	/* Pictures go to nobody but the controller's machine. */
	to->mac = controller.mac;
	return stream_address == controller.ip;
}

static uint32_t status_of(enum refusal refusal)
{
	switch (refusal) {
	case DONE: return SUCCESS;
	case BAD_VALUE: return INVALID_PARAMETER;
	case LOCKED: return ACCESS_DENIED;
	case READ_ONLY: return WRITE_PROTECT;
	default: return DEVICE_ERROR;
	}
}

static uint32_t write_control(uint32_t value, const struct udp_path *peer)
{
	if (controlled && !same(&controller, peer))
		return ACCESS_DENIED;
	if (value & ~3u)
		return INVALID_PARAMETER;
	if (!value) {
		release();
		return SUCCESS;
	}
	controller = *peer;
	controlled = true;
	heard = now64();
	privilege = value;
	return SUCCESS;
}

static uint32_t write_packet_size(uint32_t value)
{
	struct receiver to;
	uint32_t size = value & 0xffff;

	if (size < PACKET_LEAST || size > PACKET_MOST)
		return INVALID_PARAMETER;
	size = stream_packet_size(size);
	if (acquiring && size != (packet_size & 0xffff))
		return ACCESS_DENIED;
	packet_size = (value & PACKET_DO_NOT_FRAGMENT) | size;
	if (value & FIRE && receiver(&to))
		stream_test(&to, value & 0xffff);
	return SUCCESS;
}

static uint32_t write_bootstrap(uint32_t address, uint32_t value)
{
	uint32_t dummy;

	switch (address) {
	case BOOT_HeartbeatTimeout:
		heartbeat = value < HEARTBEAT_LEAST ? HEARTBEAT_LEAST : value;
		return SUCCESS;
	case BOOT_TimestampControl:
		if (value & 2)
			stamp = now64() * (1000000000u / CLOCK_HZ);
		return SUCCESS;
	case BOOT_StreamPort:
		if (value > PORTS_MAX)
			return INVALID_PARAMETER;
		if (acquiring && value != stream_port)
			return ACCESS_DENIED;
		stream_port = value;
		return SUCCESS;
	case BOOT_StreamAddress:
		if (acquiring && value != stream_address)
			return ACCESS_DENIED;
		stream_address = value;
		return SUCCESS;
	case BOOT_StreamPacketDelay:
		if (value > DELAY_MOST)
			return INVALID_PARAMETER;
		stream_delay = value;
		return SUCCESS;
	case BOOT_StreamPacketSize:
		return write_packet_size(value);
	}
	return read_word(address, &dummy) == INVALID_ADDRESS ? INVALID_ADDRESS : WRITE_PROTECT;
}

static uint32_t write_own(const struct feature *one, uint32_t value)
{
	struct receiver to;

	if (value < one->low || value > one->high)
		return INVALID_PARAMETER;
	switch (one->id) {
	case FEATURE_AcquisitionMode:
		if (acquiring)
			return ACCESS_DENIED;
		if (value > 1)
			return INVALID_PARAMETER;
		single = value;
		return SUCCESS;
	case FEATURE_TLParamsLocked:
		tl_locked = value;
		words_streaming = value || acquiring;
		return SUCCESS;
	case FEATURE_AcquisitionStart:
		if (!value || acquiring)
			return SUCCESS;
		if (!receiver(&to))
			return ACCESS_DENIED;
		acquiring = words_streaming = true;
		stream_start(&to, single);
		return SUCCESS;
	case FEATURE_AcquisitionStop:
		if (value) {
			stream_stop();
			acquiring = false;
			words_streaming = tl_locked;
		}
		return SUCCESS;
	case FEATURE_SensorRegisterAddress:
		sensor_address = value;
		return SUCCESS;
	case FEATURE_SensorRegisterValue:
		return status_of(word_write(sensor_address, value));
	}
	return WRITE_PROTECT;
}

static uint32_t write_word(uint32_t address, uint32_t value, const struct udp_path *peer)
{
	const struct feature *one = feature_at(address);

	if (address % 4)
		return BAD_ALIGNMENT;
	if (address == BOOT_ControlPrivilege)
		return write_control(value, peer);
	if (!controlled || !same(&controller, peer))
		return ACCESS_DENIED;
	if (address - GVCP_CORRECTOR_BASE < GVCP_CORRECTOR_BYTES) {
		reg_write(NCDC_BASE + (address - GVCP_CORRECTOR_BASE), value);
		return SUCCESS;
	}
	if (!one)
		return write_bootstrap(address, value);
	if (one->access == 'r')
		return WRITE_PROTECT;
	return one->lower == NO_WORD ? write_own(one, value) : status_of(feature_write(one, value));
}

/* Commands: each takes its data, writes those of its answer, and gives a status. */

static uint32_t read_registers(const uint8_t *data, uint32_t length, uint8_t *to, uint32_t *size)
{
	if (!length || length % 4 || length > 4 * REGISTERS_MAX)
		return INVALID_HEADER;
	for (uint32_t k = 0; k < length; k += 4) {
		uint32_t value = 0, status = read_word(get32(data + k), &value);

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
		uint32_t status = write_word(get32(data + k), get32(data + k + 4), peer);

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
	status = read_memory(get32(data), count, to + 4);
	*size = 4 + count;
	return status;
}

static uint32_t write_block(const uint8_t *data, uint32_t length, const struct udp_path *peer,
			    uint8_t *to, uint32_t *size)
{
	if (length < 8 || length > 4 + MEMORY_MAX || length % 4)
		return INVALID_HEADER;
	for (uint32_t k = 4; k < length; k += 4) {
		uint32_t status = write_word(get32(data) + k - 4, get32(data + k), peer);

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
	if (length < 12 || !controlled || peer->ip != controller.ip)
		return;
	stream_resend(get16(data + 2), get32(data + 4) & 0xffffff, get32(data + 8) & 0xffffff);
}

static uint32_t carry_out(uint32_t code, const uint8_t *data, uint32_t length,
			  const struct udp_path *peer, uint8_t *to, uint32_t *size)
{
	switch (code) {
	case DISCOVERY:
		*size = GVCP_DISCOVERY_BYTES;
		return read_memory(0, GVCP_DISCOVERY_BYTES, to);
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
	if (controlled && same(&controller, &datagram.from))
		heard = now64();
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
	eth_send((uint8_t *)answer_words, ETH_HEADER + IP_HEADER + UDP_HEADER + HEADER + size);
	return true;
}
