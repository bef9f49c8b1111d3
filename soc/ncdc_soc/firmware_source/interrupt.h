/* The system's interrupt: frames that are complete. */
#ifndef INTERRUPT_H
#define INTERRUPT_H

#include <stdbool.h>
#include <stdint.h>

/* Frames completed since the reset, raw ones or corrected ones. */
uint32_t interrupt_frames(bool raw);

/* Lets the system interrupt the processor. */
void interrupt_begin(void);

/* Lets these lines interrupt the processor: start.S, or the test on a PC. */
void interrupts_let(uint32_t lines);

/* Called at an interrupt. */
void interrupted(void);

#endif
