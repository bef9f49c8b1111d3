#include "sensor.h"

#include "hw.h"

#define TRIES 3		/* of a transfer */

struct write {
	uint16_t address, value;
	uint32_t wait_us;
};

static const struct write SET_UP[] = SENSOR_SET_UP;

#define WRITES (sizeof SET_UP / sizeof *SET_UP)

/* Sends or receives a byte; what was received, or -1. */
static int32_t byte(uint32_t command)
{
	uint32_t result;

	reg_write(NCDC_I2C_COMMAND, command);
	do
		result = reg_read(NCDC_I2C_RESULT);
	while (result & NCDC_I2C_RESULT_BUSY);
	if (result & (NCDC_I2C_RESULT_NACK | NCDC_I2C_RESULT_LOST | NCDC_I2C_RESULT_TIMEOUT))
		return -1;
	return (int32_t)(result & NCDC_I2C_RESULT_DATA);
}

/* Sends a number of one or two bytes, the last one with the flags `more`. */
static int send(uint32_t value, uint32_t bits, uint32_t more)
{
	if (bits == 16 && byte(value >> 8 | NCDC_I2C_COMMAND_WRITE) < 0)
		return -1;
	return byte((value & 0xff) | NCDC_I2C_COMMAND_WRITE | more) < 0 ? -1 : 0;
}

static int address_it(uint32_t address)
{
	if (byte(SENSOR_I2C << 1 | NCDC_I2C_COMMAND_START | NCDC_I2C_COMMAND_WRITE) < 0)
		return -1;
	return send(address, SENSOR_POINTER_BITS, 0);
}

int sensor_write(uint32_t address, uint32_t value)
{
	for (int k = 0; k < TRIES; ++k)
		if (!address_it(address) &&
		    !send(value, SENSOR_VALUE_BITS, NCDC_I2C_COMMAND_STOP))
			return 0;
	return -1;
}

static int32_t read_once(uint32_t address)
{
	int32_t upper = 0, lower;

	if (address_it(address) || byte(SENSOR_I2C << 1 | 1 | NCDC_I2C_COMMAND_START |
					NCDC_I2C_COMMAND_WRITE) < 0)
		return -1;
	if (SENSOR_VALUE_BITS == 16 && (upper = byte(NCDC_I2C_COMMAND_READ)) < 0)
		return -1;
	lower = byte(NCDC_I2C_COMMAND_READ | NCDC_I2C_COMMAND_NACK | NCDC_I2C_COMMAND_STOP);
	return lower < 0 ? -1 : upper << 8 | lower;
}

int32_t sensor_read(uint32_t address)
{
	int32_t value = -1;

	for (int k = 0; k < TRIES && value < 0; ++k)
		value = read_once(address);
	return value;
}

int sensor_set_up(void)
{
	if (sensor_read(SENSOR_ID_ADDRESS) != SENSOR_ID)
		return -1;
	for (unsigned k = 0; k + 1 < WRITES; ++k) {
		uint32_t begin = now32();

		if (sensor_write(SET_UP[k].address, SET_UP[k].value))
			return -1;
		while (now32() - begin < SET_UP[k].wait_us * SENSOR_WAIT_CLOCKS)
			;
	}
	return 0;
}

int sensor_start(void)
{
	return sensor_write(SET_UP[WRITES - 1].address, SET_UP[WRITES - 1].value);
}
