/* The lens in the EEPROM on the sensor's I2C bus: a chip of the 24C kind, at 0x50 to 0x57. */
#ifndef EEPROM_H
#define EEPROM_H

#include <stdbool.h>
#include <stdint.h>

extern uint32_t eeprom_status;	/* of the feature EepromStatus */

/* Loads the lens, if there is a good one, and waits for the bus, on which nothing else may be under way.
 * False: not now, call it again. */
bool eeprom_load(void);

#endif
