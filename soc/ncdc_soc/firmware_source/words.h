/* The state that both protocols show: 16-bit words of Table I, and GVCP's features in them. */
#ifndef WORDS_H
#define WORDS_H

#include <stdbool.h>
#include <stdint.h>

#include "auto.h"

/* Why a write is not carried out; UNDER_WAY: the sensor's bus is at work, ask the same again in each
 * turn of the loop. */
enum refusal { DONE, BAD_VALUE, LOCKED, READ_ONLY, NO_ANSWER, UNDER_WAY };

#define NO_WORD 0xffffu

struct choice {
	uint32_t value;		/* in GVCP's register */
	uint16_t word;		/* in the word of Table I */
};

/* Of the feature at GVCP_FEATURE_BASE + 4 k; without gaps: they are many, and the ROM is small. */
struct feature {
	uint8_t id;		/* enum feature_id of config.h */
	char access;		/* 'r', 'w' or 'b' for both */
	uint16_t upper, lower;	/* addresses of its words, NO_WORD if it has none */
	uint8_t shift, width;	/* of its field in the word; width 0: the whole */
	uint8_t low, count;	/* its minimum; how many choices */
	uint32_t high;
	const struct choice *choices;
};

struct view {
	bool raw;
	uint32_t width, height, bytes, pfnc, mraw;
};

extern bool words_streaming;	/* pictures stream: size and format are locked */
extern uint32_t words_dropped, words_torn;
extern uint32_t words_changed;	/* raw frames complete when a register of the sensor was written last */

/* Reads the exposure and the gain back that the sensor was set up with. */
int words_begin(void);

struct view words_view(void);

/* Exposure and gain that the sensor has, and a change of those that the limits set free; whether it is
 * done, else the same is to be asked again in each turn of the loop. */
struct exposure words_exposure(void);
bool words_expose(const struct exposure *to, const struct limits *limits);

uint32_t words_frame_clocks(void);	/* least clocks from frame to frame */

/* The word at an address, 0 where there is none; false: as UNDER_WAY. */
bool word_read(uint32_t address, uint32_t *value);
enum refusal word_write(uint32_t address, uint32_t value);

const struct feature *feature_at(uint32_t address);
uint32_t feature_read(const struct feature *one);
enum refusal feature_write(const struct feature *one, uint32_t value);

#endif
