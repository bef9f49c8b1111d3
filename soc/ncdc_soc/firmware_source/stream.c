#include "stream.h"

#include <string.h>

#include "frames.h"
#include "hw.h"
#include "interrupt.h"
#include "ip.h"
#include "words.h"

#define LEADER_BYTES 44
#define PART_BYTES 8
#define TRAILER_BYTES 16
#define HEADERS_BYTES (ETH_HEADER + STREAM_HEADERS)
#define NUMBER_AT (ETH_HEADER + IP_HEADER + UDP_HEADER + 5)
#define NUMBER_BYTES 3
#define RANGES 64		/* of packets to be sent again, a power of two: clients ask for
				 * each missing packet of a frame, one after the other */

enum { IDLE, WAITING, PREPARING, SENDING, ENDING };

enum header { LEADER, PART, LAST, TRAILER };

struct range {
	uint32_t block, first, last;
};

uint32_t stream_frames, stream_resends;
static struct receiver to;
static int state = IDLE;
static bool single, sent_one;
static bool triggered, pulled;	/* pictures wait for a trigger; there was one */
static uint32_t exposed;	/* frames that were complete then */
static bool wanted;		/* a stream begins when the last one has ended */
static enum frame_reader reader;	/* that holds the frame sent last */
static uint32_t block;		/* number of the picture sent last, 1..65535 */
static uint32_t blocks;		/* pictures of this stream that can be sent again, at most 2 */
static uint32_t began;		/* clock of its beginning */
static uint32_t seen;		/* frames that were complete when one was claimed last */
static struct {
	enum frame_reader reader;
	struct frame frame;
	struct view view;
	uint32_t part, packets, last;	/* bytes of a packet, packets, bytes of the last one */
	unsigned header;	/* that is written next */
} next;				/* the picture that is prepared */
static struct receiver tester;	/* of a test packet, while there is one to be sent */
static struct range ranges[RANGES];
static uint32_t ranges_in, ranges_out;

uint32_t stream_packet_size(uint32_t size)
{
	if (size > LINK_CAPACITY + STREAM_HEADERS)
		size = LINK_CAPACITY + STREAM_HEADERS;
	return (size - STREAM_HEADERS) / STREAM_STEP * STREAM_STEP + STREAM_HEADERS;
}

bool stream_ended(void)
{
	return single && sent_one;
}

static void begin(void)
{
	block = 0;
	blocks = 0;
	/* Pictures that were ready before a client asked for them are not sent. */
	seen = interrupt_frames(words_view().raw);
	began = now32() - words_frame_clocks();
	state = WAITING;
}

/* No more packets of the frame. Those that are sent again may take seconds on a slow line, for which
 * nothing else waits: stream_poll sees the end. */
static void halt(void)
{
	reg_write(LINK_CONTROL, LINK_CONTROL_ABORT);
	ranges_out = ranges_in;
	state = ENDING;
}

void stream_begin(void)
{
	/* Before a watchdog's reset of the processor alone there may have been a stream. */
	frame_release(FRAMES_MRAW);
	halt();
}

void stream_start(const struct receiver *target, bool one, bool waits)
{
	stream_stop();
	to = *target;
	tester.packet_size = 0;
	single = one;
	triggered = waits;
	pulled = false;
	sent_one = false;
	wanted = state == ENDING;
	if (!wanted)
		begin();
}

void stream_trigger(void)
{
	if (!triggered || pulled)
		return;
	pulled = true;
	exposed = interrupt_frames(words_view().raw);
}

void stream_stop(void)
{
	wanted = false;
	if (state != IDLE && state != ENDING)
		halt();
}

void stream_resend(uint32_t of, uint32_t first, uint32_t last)
{
	if (state == IDLE || state == ENDING || last < first ||
	    ranges_in - ranges_out >= RANGES)
		return;
	ranges[ranges_in++ % RANGES] = (struct range){of, first, last};
}

/* Writes a header of the packetiser: its length, then its bytes. */
static void put_header(uint32_t which, const uint8_t *bytes, uint32_t length)
{
	uint32_t at = LINK_TEMPLATES + 256 * which;

	reg_write(at, length);
	for (uint32_t k = 0; k < length; k += 4) {
		uint32_t word;

		memcpy(&word, bytes + k, 4);
		reg_write(at + 4 + k, word);
	}
}

/* Ethernet, IP, UDP and GVSP's first eight bytes, before `more` bytes; where those begin. */
static uint8_t *begin_header(uint8_t *header, uint32_t kind, uint32_t number, uint32_t more)
{
	struct udp_path path = {to.mac, to.ip, to.port, STREAM_PORT};
	uint8_t *p = udp_header(header, &path, PART_BYTES + more);

	put16(p, 0);
	put16(p + 2, block);
	put32(p + 4, kind << 24 | number);
	return p + PART_BYTES;
}

/* One of the four headers of a picture of so many packets. */
static void put_one(unsigned which, const struct view *view, uint64_t time_ns, uint32_t packets,
		    uint32_t part)
{
	/* Whole words are written: the last one may be longer than the header. */
	uint32_t words[32];
	uint8_t *header = (uint8_t *)words, *p;
	uint32_t more = 0;

	switch (which) {
	case LEADER:
		more = LEADER_BYTES - PART_BYTES;
		p = begin_header(header, 1, 0, more);
		memset(p, 0, more);
		put16(p + 2, 1);		/* an image */
		put32(p + 4, (uint32_t)(time_ns >> 32));
		put32(p + 8, (uint32_t)time_ns);
		put32(p + 12, view->pfnc);
		put32(p + 16, view->width);
		put32(p + 20, view->height);
		break;
	case TRAILER:
		more = TRAILER_BYTES - PART_BYTES;
		p = begin_header(header, 2, packets + 1, more);
		put32(p, 1);			/* an image */
		put32(p + 4, view->height);
		break;
	default:
		p = begin_header(header, 3, 0, part);
	}
	put_header(which, header, (uint32_t)(p - header) + more);
}

/* How a frame is cut: bytes of a packet, packets, bytes of the last one. */
static void set_packets(uint32_t part, uint32_t packets, uint32_t last)
{
	reg_write(LINK_PAYLOAD, part);
	reg_write(LINK_PACKETS, packets);
	reg_write(LINK_LAST, last);
	reg_write(LINK_FIRST_NUMBER, 1);
}

/* Claims the newest frame, that its headers may be written; false if there is none. */
static bool claim(const struct view *view)
{
	next.reader = reader == FRAMES_STREAM0 ? FRAMES_STREAM1 : FRAMES_STREAM0;
	if (!frame_claim(next.reader, view->raw, &next.frame))
		return false;
	next.view = *view;
	next.part = to.packet_size - STREAM_HEADERS;
	next.packets = (view->bytes + next.part - 1) / next.part;
	next.last = view->bytes - (next.packets - 1) * next.part;
	next.header = LEADER;
	block = block % 0xffff + 1;
	blocks += blocks < 2;
	began = now32();
	return true;
}

/* Writes a header, or sends the frame after the last one; whether it has. A command of GVCP need not
 * wait for all of it. */
static bool prepare(void)
{
	if (next.header <= TRAILER) {
		put_one(next.header, &next.view, nanoseconds(next.frame.clock),
			next.packets, next.header == LAST ? next.last : next.part);
		++next.header;
		return false;
	}
	set_packets(next.part, next.packets, next.last);
	reg_write(LINK_NUMBER_FIELD, NUMBER_AT | NUMBER_BYTES << 8);
	reg_write(LINK_DELAY, to.delay_clocks);
	reg_write(LINK_BASE, next.frame.address);
	reg_write(LINK_CONTROL, LINK_CONTROL_SEND);
	reader = next.reader;
	return true;
}

static void send_again(void)
{
	const struct range *range = &ranges[ranges_out % RANGES];
	bool present = range->block == block;
	uint32_t before = block > 1 ? block - 1 : 0xffff;

	if ((present && blocks) || (range->block == before && blocks == 2)) {
		reg_write(LINK_RESEND_FIRST, range->first);
		reg_write(LINK_RESEND_LAST, range->last | (present ? 0 : LINK_RESEND_LAST_BEFORE));
		++stream_resends;
	}
	++ranges_out;
}

void stream_test(const struct receiver *target, uint32_t size)
{
	if ((state != IDLE && state != ENDING) || size > LINK_CAPACITY + STREAM_HEADERS)
		return;
	tester = *target;
	tester.packet_size = size;
}

/* One packet of zeros and of whatever lies in memory, as a frame without leader and trailer. */
static void send_test(void)
{
	uint32_t words[(HEADERS_BYTES + 3) / 4], part = tester.packet_size - STREAM_HEADERS;
	struct udp_path path = {tester.mac, tester.ip, tester.port, STREAM_PORT};

	memset(udp_header((uint8_t *)words, &path, PART_BYTES + part), 0, PART_BYTES);
	set_packets((part + STREAM_STEP - 1) / STREAM_STEP * STREAM_STEP, 1, part);
	reg_write(LINK_NUMBER_FIELD, 0);
	put_header(LEADER, 0, 0);
	put_header(LAST, (const uint8_t *)words, HEADERS_BYTES);
	put_header(TRAILER, 0, 0);
	reg_write(LINK_CONTROL, LINK_CONTROL_SEND);
	tester.packet_size = 0;
	state = ENDING;
}

void stream_poll(void)
{
	struct view view;
	uint32_t status, complete;

	if (state == IDLE) {
		if (tester.packet_size)
			send_test();
		return;
	}
	status = reg_read(LINK_STATUS);
	if (state == ENDING) {
		if (status & (LINK_STATUS_BUSY | LINK_STATUS_RESENDING))
			return;
		frame_release(FRAMES_STREAM0);
		frame_release(FRAMES_STREAM1);
		state = IDLE;
		if (wanted)
			begin();
		wanted = false;
		return;
	}
	if (state == PREPARING) {
		if (prepare())
			state = SENDING;
		return;
	}
	if (state == SENDING && !(status & LINK_STATUS_BUSY)) {
		++stream_frames;
		sent_one = true;
		state = WAITING;
	}
	if (status & LINK_STATUS_RESENDING)
		return;
	if (ranges_out != ranges_in) {
		send_again();
		return;
	}
	if (state == SENDING || (single && sent_one) || now32() - began < words_frame_clocks())
		return;
	view = words_view();
	complete = interrupt_frames(view.raw);
	if (complete == seen)
		return;
	/* The first frame that is complete after a trigger was exposed before it. */
	if (triggered && (!pulled || complete - exposed < 2))
		return;
	seen = complete;
	if (claim(&view)) {
		pulled = false;
		state = PREPARING;
	}
}
