#include "mraw.h"

#include <string.h>

#include "frames.h"
#include "hw.h"
#include "ip.h"
#include "lwip/sys.h"
#include "words.h"

#define HEADER 28
#define PIECE 256		/* bytes at a time: the rest of the loop must not wait for long */
#define FLYING (2 * TCP_MSS)	/* not yet acknowledged; two whole segments are, at once */
#define TIMEOUT_MS 10000	/* without a byte that is taken */
#define GRACE_MS 1000		/* while others wait, and then bytes per millisecond at least */
#define MIN_RATE 128

uint32_t mraw_packages;
static struct frame frame;	/* that is sent, to `users` */
static struct view view;
static unsigned users;
static bool borrowed;		/* the reader's frame is not of a package */
static bool others;		/* wait for this frame to be sent to all `users` */

bool mraw_claim(void)
{
	others = users;
	if (users || borrowed)
		return false;
	view = words_view();
	return frame_claim(FRAMES_MRAW, view.raw, &frame);
}

bool mraw_borrow(struct frame *to)
{
	borrowed = !users && frame_claim(FRAMES_MRAW, true, to);
	return borrowed;
}

bool mraw_give_back(void)
{
	bool held = frame_held(FRAMES_MRAW);

	frame_release(FRAMES_MRAW);
	borrowed = false;
	return held;
}

void mraw_begin(struct mraw *mraw)
{
	++users;
	mraw->state = MRAW_SENDS;
	mraw->sent = 0;
	mraw->moved_ms = sys_now();
	mraw->number = frame.number;
	mraw->watched = false;
}

void mraw_forget(struct mraw *mraw)
{
	if (mraw->state == MRAW_SENDS && !--users)
		frame_release(FRAMES_MRAW);
	mraw->state = MRAW_NONE;
}

static void put_header(uint8_t *p)
{
	memset(p, 0, HEADER);
	put32(p, view.width);
	put32(p + 4, view.height);
	p[8] = (uint8_t)view.mraw;
	put32(p + 12, view.bytes);
	put32(p + 16, ip_own);
	put32(p + 20, TABLE_PORT);
	put32(p + 24, (uint32_t)in_units(frame.clock, 1000000));
}

/* The package's next bytes; how many. */
static uint32_t piece(const struct mraw *mraw, uint32_t *words)
{
	uint32_t at = mraw->sent - HEADER, length;

	if (!mraw->sent) {
		put_header((uint8_t *)words);
		return HEADER;
	}
	length = view.bytes - at < PIECE ? view.bytes - at : PIECE;
	for (uint32_t k = 0; k < length; k += 4)
		words[k / 4] = reg_read(FRAMES_BASE + frame.address + at + k);
	return length;
}

/* Since others began to wait the user has taken less than the minimum rate. */
static bool too_slow(struct mraw *mraw)
{
	uint32_t passed = sys_now() - mraw->watched_ms;

	if (!others || !mraw->watched) {
		mraw->watched = others;
		mraw->watched_ms = sys_now();
		mraw->watched_from = mraw->sent;
		return false;
	}
	return passed > GRACE_MS && mraw->sent - mraw->watched_from < (passed - GRACE_MS) * MIN_RATE;
}

bool mraw_send(struct mraw *mraw, struct tcp_pcb *pcb)
{
	uint32_t words[PIECE / 4], length;

	if (!frame_held(FRAMES_MRAW) || sys_now() - mraw->moved_ms > TIMEOUT_MS || too_slow(mraw))
		return false;
	if (TCP_SND_BUF - tcp_sndbuf(pcb) > FLYING)
		return true;
	length = piece(mraw, words);
	/* A frame that was taken away meanwhile is not what was read. */
	if (!frame_held(FRAMES_MRAW))
		return false;
	/* Short segments wait for the next piece, except the last one. */
	tcp_nagle_enable(pcb);
	if (tcp_write(pcb, words, (uint16_t)length, TCP_WRITE_FLAG_COPY) == ERR_OK) {
		mraw->sent += length;
		mraw->moved_ms = sys_now();
	}
	if (mraw->sent == HEADER + view.bytes) {
		++mraw_packages;
		mraw_forget(mraw);
		tcp_nagle_disable(pcb);
	}
	tcp_output(pcb);
	return true;
}
