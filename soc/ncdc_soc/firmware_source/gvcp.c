#include "gvcp.h"

#include <string.h>

#include "gvcp_control.h"
#include "hw.h"
#include "net.h"
#include "stream.h"

enum { CONFIG_GVCP_COMMANDS };

#define HEADER 8
#define ANSWER 1			/* flag: the sender wants an acknowledge */
#define HEADERS (ETH_HEADER + IP_HEADER + UDP_HEADER + HEADER)
#define PENDING_BYTES 4
#define ANSWER_WORDS ((HEADERS + 4 + GVCP_MEMORY_MAX + 7) / 4)

uint32_t gvcp_commands;

/* A command, and how far it has been carried out. */
struct command {
	const struct udp_path *peer;
	const uint8_t *data;
	uint32_t code, request, length;
	uint32_t done;			/* bytes of its words that were read or written */
	uint32_t *answer;		/* the frame, with space for the headers */
	uint32_t size;			/* bytes of the answer after its header */
	bool answered;
};

/* The command that waits for the sensor's bus, its data, and its answer so far; others that come
 * meanwhile have the other answer. */
static struct command waiting;
static struct udp_path waiting_peer;
static bool waits;
static uint8_t waiting_data[4 + GVCP_MEMORY_MAX];
static uint32_t one_answer[ANSWER_WORDS], other_answer[ANSWER_WORDS];

static uint8_t *to(const struct command *command)
{
	return (uint8_t *)command->answer + HEADERS;
}

/* Commands: each takes its data, writes those of its answer, and gives a status. */

static uint32_t read_registers(struct command *command)
{
	uint32_t length = command->length;

	if (!length || length % 4 || length > 4 * GVCP_REGISTERS_MAX)
		return INVALID_HEADER;
	for (; command->done < length; command->done += 4) {
		uint32_t value = 0, status = gvcp_read_word(get32(command->data + command->done), &value);

		if (status)
			return status;
		put32(to(command) + command->done, value);
	}
	command->size = length;
	return SUCCESS;
}

static uint32_t write_registers(struct command *command)
{
	uint32_t length = command->length;

	if (!length || length % 8 || length > 4 * GVCP_REGISTERS_MAX)
		return INVALID_HEADER;
	for (; command->done < length; command->done += 8) {
		const uint8_t *data = command->data + command->done;
		uint32_t status = gvcp_write_word(get32(data), get32(data + 4), command->peer);

		if (status)
			return status;
	}
	put32(to(command), length / 8);
	command->size = 4;
	return SUCCESS;
}

static uint32_t read_block(struct command *command)
{
	uint32_t address, count;

	if (command->length != 8)
		return INVALID_HEADER;
	address = get32(command->data);
	count = get16(command->data + 6);
	if (count < 4 || count > GVCP_MEMORY_MAX)
		return INVALID_PARAMETER;
	if (count % 4)
		return BAD_ALIGNMENT;
	put32(to(command), address);
	command->size = 4 + count;
	return gvcp_read_memory(address, count, to(command) + 4, &command->done);
}

static uint32_t write_block(struct command *command)
{
	uint32_t length = command->length;

	if (length < 8 || length > 4 + GVCP_MEMORY_MAX || length % 4)
		return INVALID_HEADER;
	for (; command->done < length - 4; command->done += 4) {
		uint32_t status = gvcp_write_word(get32(command->data) + command->done,
						  get32(command->data + 4 + command->done),
						  command->peer);

		if (status)
			return status;
	}
	put32(to(command), length - 4);
	command->size = 4;
	return SUCCESS;
}

/* A command for another MAC address is not answered. */
static uint32_t force_ip(struct command *command)
{
	const uint8_t *data = command->data;

	if (command->length != GVCP_FORCEIP_BYTES)
		return INVALID_HEADER;
	if (memcmp(data + 2, ETH_OWN.bytes, sizeof ETH_OWN.bytes)) {
		command->answered = false;
		return SUCCESS;
	}
	if (control.controlled)
		return ACCESS_DENIED;
	return net_force(get32(data + 20), get32(data + 36), get32(data + 52)) ? SUCCESS
									       : INVALID_PARAMETER;
}

static void send_again(const struct command *command)
{
	const uint8_t *data = command->data;

	/* A receiver asks from a port of its own, perhaps, but from the controller's machine. */
	if (command->length < 12 || !control.controlled ||
	    command->peer->ip != control.controller.ip)
		return;
	stream_resend(get16(data + 2), get32(data + 4) & 0xffffff, get32(data + 8) & 0xffffff);
}

static uint32_t carry_out(struct command *command)
{
	switch (command->code) {
	case DISCOVERY:
		command->size = GVCP_DISCOVERY_BYTES;
		return gvcp_read_memory(0, GVCP_DISCOVERY_BYTES, to(command), &command->done);
	case FORCEIP: return force_ip(command);
	case READREG: return read_registers(command);
	case WRITEREG: return write_registers(command);
	case READMEM: return read_block(command);
	case WRITEMEM: return write_block(command);
	}
	return NOT_IMPLEMENTED;
}

/* Sends an acknowledge to a command with `size` bytes after its header in the frame. */
static void acknowledge(const struct command *command, uint32_t *frame, uint32_t code,
			uint32_t status, uint32_t size)
{
	uint8_t *header = (uint8_t *)frame + HEADERS - HEADER;

	if (!command->answered)
		return;
	put16(header, status);
	put16(header + 2, code + 1);
	put16(header + 4, size);
	put16(header + 6, command->request);
	udp_header((uint8_t *)frame, command->peer, HEADER + size);
	eth_send(frame, HEADERS + size);
}

static void end(const struct command *command, uint32_t status)
{
	acknowledge(command, command->answer, command->code, status, status ? 0 : command->size);
}

/* Sends PENDING_ACK to a client that understands it. */
static void put_off(const struct command *command)
{
	uint32_t frame[(HEADERS + PENDING_BYTES + 3) / 4];

	if (!(control.configuration & GVCP_CONFIGURATION) || !control_is(command->peer))
		return;
	put32((uint8_t *)frame + HEADERS, GVCP_PENDING_MS);
	acknowledge(command, frame, GVCP_PENDING_ACK - 1, SUCCESS, PENDING_BYTES);
}

/* Stores a command until the sensor's bus is done; one at a time. The controller's command replaces
 * another client's, which may ask again. */
static void keep(const struct command *command)
{
	if (waits && (control_is(waiting.peer) || !control_is(command->peer))) {
		end(command, BUSY);
		return;
	}
	if (waits)
		end(&waiting, BUSY);
	memcpy(waiting_data, command->data, command->length);
	waiting_peer = *command->peer;
	waiting = *command;
	waiting.data = waiting_data;
	waiting.peer = &waiting_peer;
	waits = true;
	put_off(&waiting);
}

static bool same(const struct command *command)
{
	return waits && command->peer->ip == waiting.peer->ip &&
	       command->peer->port == waiting.peer->port && command->request == waiting.request;
}

bool gvcp_frame(const uint8_t *frame, uint32_t length)
{
	struct datagram datagram;
	struct command command;
	uint32_t status;

	if (!udp_parse(frame, length, &datagram) || datagram.port != GVCP_PORT)
		return false;
	command.data = datagram.data + HEADER;
	command.length = datagram.length - HEADER;
	if (datagram.length < HEADER || datagram.data[0] != GVCP_KEY ||
	    get16(datagram.data + 4) != command.length)
		return true;
	command.peer = &datagram.from;
	command.done = command.size = 0;
	command.answered = datagram.data[1] & ANSWER;
	command.code = get16(datagram.data + 2);
	command.request = get16(datagram.data + 6);
	/* Aravis asks with the number 0, which no client should. */
	if (command.code & 1)
		return true;
	++gvcp_commands;
	if (control_is(command.peer))
		control.heard = now64();
	if (command.code == PACKETRESEND) {
		send_again(&command);
	} else if (same(&command)) {
		put_off(&waiting);		/* the client has timed out, or lost our PENDING_ACK */
	} else {
		command.answer = waits && waiting.answer == one_answer ? other_answer : one_answer;
		status = carry_out(&command);
		if (status == UNFINISHED)
			keep(&command);
		else
			end(&command, status);
	}
	return true;
}

void gvcp_begin(void)
{
	control_release();
}

void gvcp_poll(void)
{
	control_poll();
	if (waits) {
		uint32_t status = carry_out(&waiting);

		if (status != UNFINISHED) {
			waits = false;
			end(&waiting, status);
		}
	}
}
