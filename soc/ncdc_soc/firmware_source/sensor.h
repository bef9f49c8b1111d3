/* The image sensor on the I2C bus. */
#ifndef SENSOR_H
#define SENSOR_H

#include <stdbool.h>
#include <stdint.h>

/* A command of the I2C controller has failed, by its result. */
#define I2C_FAILED (NCDC_I2C_RESULT_NACK | NCDC_I2C_RESULT_LOST | NCDC_I2C_RESULT_TIMEOUT)

enum sensor_state { SENSOR_DONE, SENSOR_SILENT, SENSOR_UNDER_WAY };

/* Asks for a register to be written with `*value`, or read into it. After SENSOR_UNDER_WAY the caller
 * asks the same again in each turn of the loop. The bus is slow and has one access at a time. A
 * result that is not asked for in the turn in which it comes is dropped. */
enum sensor_state sensor_ask(bool writes, uint32_t address, uint32_t *value);

/* Whether no access is under way. */
bool sensor_idle(void);

/* Looks at the bus once, and goes on with the access that is under way. */
void sensor_poll(void);

/* Reads a register, and waits for it; its value, or -1 if the sensor does not answer. */
int32_t sensor_read(uint32_t address);

/* Checks which sensor it is, and writes its whole configuration (config.h); 0, or -1. It waits for the
 * sensor. The last write, which starts the sensor, is left to `sensor_start`. */
int sensor_set_up(void);

int sensor_start(void);

#endif
