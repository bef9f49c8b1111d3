#include "auto.h"

#include "frames.h"
#include "gvcp_control.h"
#include "hw.h"
#include "interrupt.h"
#include "mraw.h"
#include "words.h"

#define FRESH 3		/* frames from a change of the sensor's registers to one that has it whole */
#define GROUPS (AUTO_SAMPLES * AUTO_SAMPLES)
#define GROUPS_PER_TURN 4	/* of the loop: the rest of it must not wait for long */
#define COLOURS 3

struct automatic automatic;

/* Of exposure and gain: waits for a frame, adds up its samples, writes what it found. */
static struct {
	enum { WAITING, SAMPLING, WRITING } phase;
	uint32_t seen;		/* raw frames that were complete when one was claimed last */
	uint32_t changed;	/* words_changed of that frame's settings */
	struct frame frame;
	uint32_t group, sum;
	struct limits limits;
	struct exposure next;
} loop;

static uint32_t clamp(uint64_t value, uint64_t low, uint64_t high)
{
	return (uint32_t)(value < low ? low : value > high ? high : value);
}

static uint32_t distance(uint32_t a, uint32_t b)
{
	return a < b ? b - a : a - b;
}

/* Settings whose product is nearly `total`. */
static struct exposure split(uint32_t total, struct exposure now, const struct limits *limits)
{
	uint32_t lines = total / AUTO_GAIN_MIN;

	if (limits->exposure) {
		if (!limits->gain)
			lines = (total + now.gain / 2) / now.gain;
		now.lines = clamp(lines, AUTO_LINES_MIN, limits->lines);
	}
	if (limits->gain)
		now.gain = clamp((total + now.lines / 2) / now.lines, AUTO_GAIN_MIN, AUTO_GAIN_MAX);
	return now;
}

struct exposure auto_exposed(uint32_t level, struct exposure now, const struct limits *limits)
{
	uint32_t total = now.lines * now.gain, ideal, least, most;
	struct exposure found;

	if (distance(level, AUTO_TARGET) <= AUTO_BAND || !(limits->exposure || limits->gain))
		return now;
	least = (limits->exposure ? AUTO_LINES_MIN : now.lines) * (limits->gain ? AUTO_GAIN_MIN : now.gain);
	most = (limits->exposure ? limits->lines : now.lines) *
	       (limits->gain ? AUTO_GAIN_MAX : now.gain);
	if (!level)
		level = 1;
	ideal = clamp(((uint64_t)total * AUTO_TARGET + level / 2) / level, least, most);
	found = split(ideal, now, limits);
	/* Hardly nearer: the sensor has no better settings. */
	if (4 * distance(found.lines * found.gain, ideal) > 3 * distance(total, ideal))
		return now;
	return split(clamp(ideal, total / AUTO_STEP_FACTOR, total * AUTO_STEP_FACTOR), now, limits);
}

bool auto_balanced(const uint32_t sums[COLOURS], uint32_t pixels, uint32_t gains[COLOURS])
{
	uint32_t largest = 0, best[COLOURS];
	uint64_t gain = 0, sum = 0;	/* of the colour that needs the least gain */
	bool near = true;

	for (unsigned c = 0; c < COLOURS; ++c) {
		uint64_t present = gains[c] ? gains[c] : 1;

		if (sums[c] > largest)
			largest = sums[c];
		if (sums[c] && (!sum || present * sum < gain * sums[c])) {
			gain = present;
			sum = sums[c];
		}
	}
	if (largest < (uint64_t)AUTO_BALANCE_DARK * pixels || !pixels)
		return false;
	for (unsigned c = 0; c < COLOURS; ++c) {
		uint64_t half = gain * sums[c], present = gains[c] ? gains[c] : 1;

		best[c] = AUTO_RATIO_MAX;
		if (half)
			best[c] = clamp((2 * AUTO_RATIO_UNITY * present * sum + half) / (2 * half), 0,
					AUTO_RATIO_MAX);
		near &= distance(best[c], gains[c]) * AUTO_BALANCE_BAND <= best[c];
	}
	for (unsigned c = 0; c < COLOURS && !near; ++c)
		gains[c] = best[c];
	return !near;
}

bool auto_locks(uint32_t address)
{
	/* Nothing is automatic without a controller, and Table I has no words to end it. */
	if (!control.controlled)
		return false;
	return (automatic.exposure && feature_in(FEATURE_ExposureTime, address)) ||
	       (automatic.gain && feature_in(FEATURE_Gain, address));
}

bool auto_writes(void)
{
	return loop.phase == WRITING;
}

static void settle(uint32_t *mode)
{
	if (*mode == AUTO_ONCE)
		*mode = AUTO_OFF;
}

/* Exposure and gain. */

static void wait_for_frame(void)
{
	uint32_t complete = interrupt_frames(true);

	if (!control.acquiring || !(automatic.exposure || automatic.gain) ||
	    complete - words_changed < FRESH || complete == loop.seen || !mraw_borrow(&loop.frame))
		return;
	loop.seen = complete;
	loop.changed = words_changed;
	loop.group = loop.sum = 0;
	loop.phase = SAMPLING;
}

static uint32_t sample(uint32_t x, uint32_t y)
{
	uint32_t at = loop.frame.address + y * RAW_WIDTH + x;

	return reg_read(FRAMES_BASE + (at & ~3u)) >> 8 * (at & 3) & 0xff;
}

static uint32_t position(uint32_t k, uint32_t size)
{
	return 2 * ((2 * k + 1) * (size / 2) / (2 * AUTO_SAMPLES));
}

static void decide(void)
{
	struct exposure now = words_exposure();

	loop.phase = WAITING;
	/* The frame was taken away meanwhile, or its settings are not the present ones. */
	if (!mraw_give_back() || loop.changed != words_changed)
		return;
	loop.limits = (struct limits){automatic.exposure, automatic.gain, AUTO_LINES_MAX};
	loop.next = auto_exposed(loop.sum >> AUTO_LEVEL_SHIFT, now, &loop.limits);
	loop.next.gain = gain_eighths(gain_number(loop.next.gain));	/* what the sensor has of it */
	if (loop.next.lines != now.lines || loop.next.gain != now.gain) {
		loop.phase = WRITING;
		return;
	}
	settle(&automatic.exposure);
	settle(&automatic.gain);
}

static void add_samples(void)
{
	for (unsigned k = 0; k < GROUPS_PER_TURN; ++k, ++loop.group) {
		uint32_t x = position(loop.group % AUTO_SAMPLES, RAW_WIDTH);
		uint32_t y = position(loop.group / AUTO_SAMPLES, RAW_HEIGHT);

		loop.sum += sample(x, y) + sample(x + 1, y) + sample(x, y + 1) +
			    sample(x + 1, y + 1);
	}
	if (loop.group == GROUPS)
		decide();
}

/* White balance, by the gains of capture. */

static uint32_t balanced_at;	/* corrected frames that were complete then */
static uint32_t changed_at;	/* raw frames that were begun when the gains were written last */

uint32_t auto_ratio(void)
{
	return reg_read(NCDC_CAPTURE_GAINS) >> AUTO_RATIO_BITS * automatic.selector & AUTO_RATIO_MAX;
}

static void put_gains(uint32_t word)
{
	reg_write(NCDC_CAPTURE_GAINS, word);
	changed_at = reg_read(NCDC_RAW_BEGUN);
}

void auto_set_ratio(uint32_t gain)
{
	uint32_t shift = AUTO_RATIO_BITS * automatic.selector;

	put_gains((reg_read(NCDC_CAPTURE_GAINS) & ~(AUTO_RATIO_MAX << shift)) | gain << shift);
}

static void balance_poll(void)
{
	uint32_t sums[COLOURS], gains[COLOURS], frames, pixels, word;
	uint32_t complete = interrupt_frames(false);

	if (!AUTO_COLOUR || !automatic.balance || !control.acquiring || words_view().raw ||
	    complete == balanced_at)
		return;
	frames = reg_read(NCDC_BASE + CORRECTOR_FRAMES);
	for (unsigned c = 0; c < COLOURS; ++c)
		sums[c] = reg_read(NCDC_BASE + CORRECTOR_SUMS + 4 * c);
	pixels = reg_read(NCDC_BASE + CORRECTOR_PIXELS);
	/* The frame that was under way when the gains were written has others, and so may the one
	 * that began just then. */
	if ((int32_t)(reg_read(NCDC_CORRECTED_NUMBER) - changed_at) < 2)
		return;
	/* Another frame has ended meanwhile: these may be sums of both. */
	if (reg_read(NCDC_BASE + CORRECTOR_FRAMES) != frames)
		return;
	balanced_at = complete;
	word = reg_read(NCDC_CAPTURE_GAINS);
	for (unsigned c = 0; c < COLOURS; ++c)
		gains[c] = word >> AUTO_RATIO_BITS * c & AUTO_RATIO_MAX;
	if (!auto_balanced(sums, pixels, gains)) {
		settle(&automatic.balance);
		return;
	}
	for (unsigned c = word = 0; c < COLOURS; ++c)
		word |= gains[c] << AUTO_RATIO_BITS * c;
	put_gains(word);
}

void auto_poll(void)
{
	if (loop.phase == WAITING)
		wait_for_frame();
	else if (loop.phase == SAMPLING)
		add_samples();
	else if (words_expose(&loop.next, &loop.limits))
		loop.phase = WAITING;
	balance_poll();
}
