/* Copies by words where both sides allow it: the C library's go byte by byte. */
#include <stddef.h>
#include <stdint.h>
#include <string.h>

typedef uint32_t __attribute__((may_alias)) word;

void *memcpy(void *restrict to, const void *restrict from, size_t size)
{
	uint8_t *t = to;
	const uint8_t *f = from;

	if (!(((uintptr_t)t | (uintptr_t)f) & 3))
		for (; size >= 4; size -= 4, t += 4, f += 4)
			*(word *)t = *(const word *)f;
	while (size--)
		*t++ = *f++;
	return to;
}

void *memset(void *to, int value, size_t size)
{
	uint8_t *t = to;
	word all = (uint8_t)value * 0x01010101u;

	if (!((uintptr_t)t & 3))
		for (; size >= 4; size -= 4, t += 4)
			*(word *)t = all;
	while (size--)
		*t++ = (uint8_t)value;
	return to;
}
