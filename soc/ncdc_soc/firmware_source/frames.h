/* Frames in memory: which buffer holds the newest one. */
#ifndef FRAMES_H
#define FRAMES_H

#include <stdbool.h>
#include <stdint.h>

/* The firmware's readers of frames; one holds a buffer at a time. */
enum frame_reader { FRAMES_STREAM0, FRAMES_STREAM1, FRAMES_MRAW };

struct frame {
	uint32_t address;	/* of its first byte, for the hosts of the memory */
	uint32_t number;	/* of the raw frame, from 1 on */
	uint64_t clock;		/* at which the raw frame began */
};

/* Claims the newest frame, raw or corrected; false if there is none. What the reader held before it
 * holds no more. */
bool frame_claim(enum frame_reader reader, bool raw, struct frame *frame);

void frame_release(enum frame_reader reader);

/* Whether the reader still holds what it claimed. */
bool frame_held(enum frame_reader reader);

#endif
