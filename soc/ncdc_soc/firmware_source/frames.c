#include "frames.h"

#include "hw.h"

static uint32_t register_of(enum frame_reader reader)
{
	return NCDC_READER0 + 4 * (FIRST_READER + (uint32_t)reader);
}

bool frame_claim(enum frame_reader reader, bool raw, struct frame *frame)
{
	uint32_t at = raw ? NCDC_RAW0_BASE : NCDC_CORRECTED0_BASE, held;

	reg_write(register_of(reader),
		  raw ? NCDC_READER0_CLAIM_RAW : NCDC_READER0_CLAIM_CORRECTED);
	held = reg_read(register_of(reader));
	if (!(held & NCDC_READER0_HELD))
		return false;
	at += 16 * (held >> NCDC_READER0_BUFFER_SHIFT & 15);
	frame->address = reg_read(at);
	frame->number = reg_read(at + 4);
	frame->clock = (uint64_t)reg_read(at + 12) << 32 | reg_read(at + 8);
	return true;
}

void frame_release(enum frame_reader reader)
{
	reg_write(register_of(reader), NCDC_READER0_RELEASE);
}

bool frame_held(enum frame_reader reader)
{
	return reg_read(register_of(reader)) & NCDC_READER0_HELD;
}
