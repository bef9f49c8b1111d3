#include "chip.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "config.h"

#define CHIP 0x52
#define BYTES_MAX 4096

static uint8_t content[BYTES_MAX];
static uint32_t size;			/* 0: there is no chip */
static unsigned address_bytes, busy, got;
static uint32_t at = 0x123;		/* where the last access has left it */
static bool selected;

void chip_begin(const char *file, unsigned bytes, unsigned times)
{
	FILE *image = fopen(file, "rb");

	if (!image)
		abort();
	address_bytes = bytes;
	busy = times;
	size = bytes == 1 ? 2048 : BYTES_MAX;
	memset(content, 0xff, sizeof content);
	for (uint32_t k = 0; k < size && fread(content + k, 1, 1, image); ++k)
		;
	fclose(image);
}

/* A byte after the chip's own address: of an address in it, or data, which wait for a STOP that does not
 * come. */
static void take(uint32_t byte)
{
	if (got == address_bytes) {
		++at;
		return;
	}
	if (address_bytes == 1)
		at = byte;
	else
		at = got ? (at & 0xff00) | byte : (at & 0xff) | byte << 8;
	++got;
}

bool chip_i2c(uint32_t command, uint32_t *result)
{
	uint32_t byte = command & 0xff;

	if (command & NCDC_I2C_COMMAND_START) {
		got = 0;
		selected = size && byte >> 1 == CHIP;
		if (selected && busy) {
			--busy;
			selected = false;
		}
	} else if (selected && command & NCDC_I2C_COMMAND_WRITE) {
		take(byte);
	} else if (selected && command & NCDC_I2C_COMMAND_READ) {
		*result = content[at++ % size];
	}
	return selected;
}
