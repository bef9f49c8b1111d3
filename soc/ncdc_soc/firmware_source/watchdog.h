/* The watchdog: begins everything anew when the loop stands still for a second. */
#ifndef WATCHDOG_H
#define WATCHDOG_H

#include "hw.h"

/* Bits of LiteX's control register. */
#define WATCHDOG_FEED 0x1u
#define WATCHDOG_ENABLE 0x100u
#define WATCHDOG_RESET 0x10000u

static inline void watchdog_feed(void)
{
	reg_write(CSR_WATCHDOG_CONTROL, WATCHDOG_RESET | WATCHDOG_ENABLE | WATCHDOG_FEED);
}

static inline void watchdog_begin(void)
{
	reg_write(CSR_WATCHDOG_CYCLES, 1000u * MILLISECOND_CLOCKS);
	watchdog_feed();
}

#endif
