/* The image sensor on the I2C bus. */
#ifndef SENSOR_H
#define SENSOR_H

#include <stdint.h>

/* Writes a register; 0, or -1 if the sensor does not answer. */
int sensor_write(uint32_t address, uint32_t value);

/* Reads a register; its value, or -1 if the sensor does not answer. */
int32_t sensor_read(uint32_t address);

/* Checks which sensor it is, and writes its whole set-up (config.h); 0, or -1. The last write,
 * which starts the sensor, is left to `sensor_start`. */
int sensor_set_up(void);

int sensor_start(void);

#endif
