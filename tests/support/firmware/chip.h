/* An EEPROM of the 24C kind on the I2C bus, a byte at a time: a 24C16 with addresses of one byte, or a
 * 24C32 with two. */
#ifndef CHIP_H
#define CHIP_H

#include <stdbool.h>
#include <stdint.h>

/* Fills the chip from a file, and with ones after it. It does not answer to its address at first, `busy`
 * times, as after a write. */
void chip_begin(const char *file, unsigned address_bytes, unsigned busy);

/* Takes a command of the I2C controller; false if it is for another chip. */
bool chip_i2c(uint32_t command, uint32_t *result);

#endif
