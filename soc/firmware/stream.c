#include "stream.h"

#include <string.h>

#include "frames.h"
#include "hw.h"
#include "ip.h"
#include "words.h"

#define LEADER_BYTES 44
#define PART_BYTES 8
#define TRAILER_BYTES 16
#define NUMBER_AT (ETH_HEADER + IP_HEADER + UDP_HEADER + 5)
#define NUMBER_BYTES 3
#define RANGES 8		/* that may wait to be sent again, a power of two */

enum { IDLE, WAITING, SENDING, ENDING };

struct range {
	uint32_t block, first, last;
};

uint32_t stream_frames, stream_resends;
static struct receiver to;
static int state = IDLE;
static bool single, sent_one;
static bool wanted;		/* a stream begins when the last one has ended */
static enum frame_reader reader;	/* that holds the frame sent last */
static uint32_t block;		/* number of the picture sent last, 1..65535 */
static uint32_t blocks;		/* pictures of this stream that can be sent again, at most 2 */
static uint32_t began;		/* clock of its beginning */
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
	/* Pictures that were ready before somebody wanted them are not sent. */
	reg_write(NCDC_CAMERA_STATUS,
		  NCDC_CAMERA_STATUS_RAW_FRAME | NCDC_CAMERA_STATUS_CORRECTED_FRAME);
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

void stream_start(const struct receiver *target, bool one)
{
	stream_stop();
	to = *target;
	single = one;
	sent_one = false;
	wanted = state == ENDING;
	if (!wanted)
		begin();
}

void stream_stop(void)
{
	wanted = false;
	if (state == WAITING || state == SENDING)
		halt();
}

void stream_resend(uint32_t of, uint32_t first, uint32_t last)
{
	if ((state != WAITING && state != SENDING) || last < first ||
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

static void put_headers(const struct view *view, uint64_t time_ns, uint32_t packets, uint32_t part,
			uint32_t last)
{
	/* Whole words are written: the last one may be longer than the header. */
	uint32_t words[32];
	uint8_t *header = (uint8_t *)words, *p;

	p = begin_header(header, 1, 0, LEADER_BYTES - PART_BYTES);
	memset(p, 0, LEADER_BYTES - PART_BYTES);
	put16(p + 2, 1);			/* an image */
	put32(p + 4, (uint32_t)(time_ns >> 32));
	put32(p + 8, (uint32_t)time_ns);
	put32(p + 12, view->pfnc);
	put32(p + 16, view->width);
	put32(p + 20, view->height);
	put_header(0, header, (uint32_t)(p - header) + LEADER_BYTES - PART_BYTES);
	p = begin_header(header, 3, 0, part);
	put_header(1, header, (uint32_t)(p - header));
	p = begin_header(header, 3, 0, last);
	put_header(2, header, (uint32_t)(p - header));
	p = begin_header(header, 2, packets + 1, TRAILER_BYTES - PART_BYTES);
	put32(p, 1);				/* an image */
	put32(p + 4, view->height);
	put_header(3, header, (uint32_t)(p - header) + TRAILER_BYTES - PART_BYTES);
}

/* Claims the newest frame and sends it; false if there is none. */
static bool send(const struct view *view)
{
	enum frame_reader next = reader == FRAMES_STREAM0 ? FRAMES_STREAM1 : FRAMES_STREAM0;
	uint32_t part = to.packet_size - STREAM_HEADERS, packets;
	struct frame frame;

	if (!frame_claim(next, view->raw, &frame))
		return false;
	packets = (view->bytes + part - 1) / part;
	block = block % 0xffff + 1;
	reg_write(LINK_PAYLOAD, part);
	reg_write(LINK_PACKETS, packets);
	reg_write(LINK_LAST, view->bytes - (packets - 1) * part);
	reg_write(LINK_FIRST_NUMBER, 1);
	reg_write(LINK_NUMBER_FIELD, NUMBER_AT | NUMBER_BYTES << 8);
	reg_write(LINK_DELAY, to.delay_clocks);
	reg_write(LINK_BASE, frame.address);
	put_headers(view, frame.clock * (1000000000u / CLOCK_HZ), packets, part,
		    view->bytes - (packets - 1) * part);
	reg_write(LINK_STATUS, LINK_STATUS_DONE);
	reg_write(LINK_CONTROL, LINK_CONTROL_SEND);
	reader = next;
	blocks += blocks < 2;
	began = now32();
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

void stream_poll(void)
{
	struct view view;
	uint32_t status, event;

	if (state == IDLE)
		return;
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
	event = view.raw ? NCDC_CAMERA_STATUS_RAW_FRAME : NCDC_CAMERA_STATUS_CORRECTED_FRAME;
	if (!(reg_read(NCDC_CAMERA_STATUS) & event))
		return;
	reg_write(NCDC_CAMERA_STATUS, event);
	if (send(&view))
		state = SENDING;
}

void stream_test(const struct receiver *target, uint32_t size)
{
	static uint32_t words[(ETH_LONGEST + 3) / 4];
	struct udp_path path = {target->mac, target->ip, target->port, STREAM_PORT};

	if (size < IP_HEADER + UDP_HEADER || ETH_HEADER + size > ETH_LONGEST)
		return;
	memset(words, 0, sizeof words);
	udp_header((uint8_t *)words, &path, size - IP_HEADER - UDP_HEADER);
	eth_send(words, ETH_HEADER + size);
}
