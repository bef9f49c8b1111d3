/* Access to the hardware. On the processor registers are words of memory; on a PC, where the same
 * firmware is tested, functions of the test stand for them (FIRMWARE_HOST). */
#ifndef HW_H
#define HW_H

#include <stddef.h>
#include <stdint.h>

#include "config.h"

#ifdef FIRMWARE_HOST
uint32_t reg_read(uint32_t address);
void reg_write(uint32_t address, uint32_t value);
#else
static inline uint32_t reg_read(uint32_t address)
{
	return *(volatile uint32_t *)(uintptr_t)address;
}

static inline void reg_write(uint32_t address, uint32_t value)
{
	*(volatile uint32_t *)(uintptr_t)address = value;
}
#endif

/* Numbers on a network are big endian and stand anywhere. */
static inline uint32_t get16(const uint8_t *p)
{
	return (uint32_t)p[0] << 8 | p[1];
}

static inline uint32_t get32(const uint8_t *p)
{
	return get16(p) << 16 | get16(p + 2);
}

static inline void put16(uint8_t *p, uint32_t value)
{
	p[0] = (uint8_t)(value >> 8);
	p[1] = (uint8_t)value;
}

static inline void put32(uint8_t *p, uint32_t value)
{
	put16(p, value >> 16);
	put16(p + 2, value);
}

/* `units` a second, of so many clocks: exact for any clock frequency. */
static inline uint64_t in_units(uint64_t clocks, uint32_t units)
{
	if (units % CLOCK_HZ == 0)		/* a constant: no division is left of this */
		return clocks * (units / CLOCK_HZ);
	return clocks / CLOCK_HZ * units + clocks % CLOCK_HZ * units / CLOCK_HZ;
}

static inline uint64_t nanoseconds(uint64_t clocks)
{
	return in_units(clocks, 1000000000u);
}

/* Clocks since the reset. */
static inline uint32_t now32(void)
{
	return reg_read(NCDC_TIME_LOW);
}

static inline uint64_t now64(void)
{
	uint32_t high, low;

	do {
		high = reg_read(NCDC_TIME_HIGH);
		low = reg_read(NCDC_TIME_LOW);
	} while (high != reg_read(NCDC_TIME_HIGH));
	return (uint64_t)high << 32 | low;
}

#endif
