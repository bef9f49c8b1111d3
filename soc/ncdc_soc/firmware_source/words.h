/* The state that both protocols show: 16-bit words of Table I, and GVCP's features in them. */
#ifndef WORDS_H
#define WORDS_H

#include <stdbool.h>
#include <stdint.h>

#include "auto.h"
#include "hw.h"

/* Why a write is not carried out; UNDER_WAY: the sensor's bus is at work, ask the same again in each
 * turn of the loop. */
enum refusal { DONE, BAD_VALUE, LOCKED, READ_ONLY, NO_ANSWER, UNDER_WAY };

/* Bits of a number that lie in a word. */
struct part {
	uint16_t address;
	uint8_t shift, width;	/* lowest of the bits in the word, how many */
	uint8_t low;		/* lowest of them in the number */
};

struct choice {
	uint32_t value;		/* in GVCP's register */
	uint16_t word;		/* in the word of Table I */
};

/* Of the feature at GVCP_FEATURE_BASE + 4 k; without gaps: they are many, and the ROM is small. */
struct feature {
	uint8_t id;		/* enum feature_id of config.h */
	char access;		/* 'r', 'w' or 'b' for both */
	uint8_t first, parts;	/* of its parts in `feature_parts`; how many, 0 if it is in no word */
	uint8_t count;		/* how many choices */
	int16_t low;		/* its minimum; below 0 the register has a sign */
	uint32_t high;
	const struct choice *choices;
};

struct view {
	bool raw;
	uint32_t width, height, bytes, pfnc, mraw;
};

extern const struct part feature_parts[];

extern bool words_streaming;	/* pictures stream: size and format are locked */
extern uint32_t words_dropped, words_torn;
extern uint32_t words_changed;	/* raw frames complete when a register of the sensor was written last */

/* Reads the settings back that the sensor was set up with. */
int words_begin(void);

struct view words_view(void);

/* An analog gain in eighths, and the number of it that is in the sensor's registers. The sensor's gain is
 * (m0 number + c0) / (m1 number + c1). */
static inline uint32_t gain_number(uint32_t eighths)
{
	int over = (int)eighths * SENSOR_GAIN_C1 - 8 * SENSOR_GAIN_C0;
	int under = 8 * SENSOR_GAIN_M0 - (int)eighths * SENSOR_GAIN_M1;

	return (uint32_t)((over + under / 2) / under);
}

static inline uint32_t gain_eighths(uint32_t number)
{
	int under = SENSOR_GAIN_M1 * (int)number + SENSOR_GAIN_C1;
	int eighths = (8 * (SENSOR_GAIN_M0 * (int)number + SENSOR_GAIN_C0) + under / 2) / under;

	return eighths > (int)AUTO_GAIN_MIN ? (uint32_t)eighths : AUTO_GAIN_MIN;
}

/* Exposure and gain that the sensor has, and a change of those that the limits set free; whether it is
 * done, else the same is to be asked again in each turn of the loop. */
struct exposure words_exposure(void);
bool words_expose(const struct exposure *to, const struct limits *limits);

uint32_t words_frame_clocks(void);	/* least clocks from frame to frame */

/* The word at an address, 0 where there is none; false: as UNDER_WAY. */
bool word_read(uint32_t address, uint32_t *value);
enum refusal word_write(uint32_t address, uint32_t value);

const struct feature *feature_at(uint32_t address);
const struct feature *feature_of(enum feature_id id);

/* Whether a word has a part of the feature. */
bool feature_in(enum feature_id id, uint32_t address);
uint32_t feature_read(const struct feature *one);

/* Whether a number is between the limits of a feature without choices. */
bool feature_takes(const struct feature *one, uint32_t value);
enum refusal feature_write(const struct feature *one, uint32_t value);

#endif
