#include "interrupt.h"

#include "hw.h"

#define FRAMES (NCDC_CAMERA_STATUS_RAW_FRAME | NCDC_CAMERA_STATUS_CORRECTED_FRAME)
#define FIRST_EVENT 8		/* bit of CAMERA_STATUS whose enable is bit 0 */

/* Written at an interrupt alone: the loop compares, so that neither waits for the other. */
static volatile uint32_t frames[2];

uint32_t interrupt_frames(bool raw)
{
	return frames[raw];
}

void interrupted(void)
{
	uint32_t events = reg_read(NCDC_CAMERA_STATUS) & FRAMES;

	/* Ended before they are counted: one that comes meanwhile interrupts again. */
	reg_write(NCDC_CAMERA_STATUS, events);
	reg_write(LINK_STATUS, LINK_STATUS_DONE | LINK_STATUS_RESENT);
	frames[0] += !!(events & NCDC_CAMERA_STATUS_CORRECTED_FRAME);
	frames[1] += !!(events & NCDC_CAMERA_STATUS_RAW_FRAME);
}

void interrupt_begin(void)
{
	reg_write(NCDC_CAMERA_IRQ_ENABLE, FRAMES >> FIRST_EVENT);
	reg_write(CSR_SYSTEM_EV_ENABLE, 1);
	interrupts_let(1u << SYSTEM_INTERRUPT);
}
