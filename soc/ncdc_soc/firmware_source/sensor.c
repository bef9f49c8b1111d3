#include "sensor.h"

#include "hw.h"

#define TRIES 3		/* of an access */
#define MAX_BYTES 6	/* bytes of one */

struct write {
	uint16_t address, value;
	uint32_t wait_us;
};

static const struct write SET_UP[] = SENSOR_SET_UP;

#define WRITES (sizeof SET_UP / sizeof *SET_UP)

enum phase { IDLE, MOVING, OVER };

/* The access that the bus is at work with, or has ended in this turn of the loop. */
static struct {
	enum phase phase;
	bool writes, failed;
	uint32_t address, value;
	uint32_t commands[MAX_BYTES];	/* of the I2C controller, one for each byte */
	unsigned count, sent, tries;
	uint32_t received;
} bus;

static void add(uint32_t command)
{
	bus.commands[bus.count++] = command;
}

static void add_number(uint32_t number, uint32_t bits, uint32_t more)
{
	if (bits == 16)
		add((number >> 8 & 0xff) | NCDC_I2C_COMMAND_WRITE);
	add((number & 0xff) | NCDC_I2C_COMMAND_WRITE | more);
}

static void try_it(void)
{
	bus.sent = 0;
	bus.received = 0;
	reg_write(NCDC_I2C_COMMAND, bus.commands[0]);
}

static void begin(bool writes, uint32_t address, uint32_t value)
{
	bus.phase = MOVING;
	bus.writes = writes;
	bus.address = address;
	bus.value = value;
	bus.count = 0;
	bus.tries = 1;
	add(SENSOR_I2C << 1 | NCDC_I2C_COMMAND_START | NCDC_I2C_COMMAND_WRITE);
	add_number(address, SENSOR_POINTER_BITS, 0);
	if (writes) {
		add_number(value, SENSOR_VALUE_BITS, NCDC_I2C_COMMAND_STOP);
	} else {
		add(SENSOR_I2C << 1 | 1 | NCDC_I2C_COMMAND_START | NCDC_I2C_COMMAND_WRITE);
		if (SENSOR_VALUE_BITS == 16)
			add(NCDC_I2C_COMMAND_READ);
		add(NCDC_I2C_COMMAND_READ | NCDC_I2C_COMMAND_NACK | NCDC_I2C_COMMAND_STOP);
	}
	try_it();
}

bool sensor_idle(void)
{
	return bus.phase != MOVING;
}

void sensor_poll(void)
{
	uint32_t result;

	if (bus.phase != MOVING) {
		/* Not sooner: who asks for one access after the other would keep all others off. */
		bus.phase = IDLE;
		return;
	}
	result = reg_read(NCDC_I2C_RESULT);
	if (result & NCDC_I2C_RESULT_BUSY)
		return;
	bus.failed = result & I2C_FAILED;
	if (bus.failed && bus.tries < TRIES) {
		++bus.tries;
		try_it();
		return;
	}
	if (bus.commands[bus.sent] & NCDC_I2C_COMMAND_READ)
		bus.received = bus.received << 8 | (result & NCDC_I2C_RESULT_DATA);
	if (bus.failed || ++bus.sent == bus.count)
		bus.phase = OVER;
	else
		reg_write(NCDC_I2C_COMMAND, bus.commands[bus.sent]);
}

enum sensor_state sensor_ask(bool writes, uint32_t address, uint32_t *value)
{
	if (bus.phase == OVER && bus.writes == writes && bus.address == address &&
	    (!writes || bus.value == *value)) {
		if (bus.failed)
			return SENSOR_SILENT;
		if (!writes)
			*value = bus.received;
		return SENSOR_DONE;
	}
	if (bus.phase == IDLE)
		begin(writes, address, *value);
	return SENSOR_UNDER_WAY;
}

static int wait(bool writes, uint32_t address, uint32_t *value)
{
	enum sensor_state state;

	while ((state = sensor_ask(writes, address, value)) == SENSOR_UNDER_WAY)
		sensor_poll();
	return state == SENSOR_DONE ? 0 : -1;
}

int32_t sensor_read(uint32_t address)
{
	uint32_t value = 0;

	return wait(false, address, &value) ? -1 : (int32_t)value;
}

static int sensor_write(const struct write *write)
{
	uint32_t value = write->value;

	return wait(true, write->address, &value);
}

int sensor_set_up(void)
{
	uint32_t woken = now32();

	/* Its reset may have ended as the firmware began. */
	while (now32() - woken < SENSOR_REST_CLOCKS)
		;
	if (sensor_read(SENSOR_ID_ADDRESS) != SENSOR_ID)
		return -1;
	for (unsigned k = 0; k + 1 < WRITES; ++k) {
		uint32_t begin = now32();

		if (sensor_write(&SET_UP[k]))
			return -1;
		while (now32() - begin < SET_UP[k].wait_us * SENSOR_WAIT_CLOCKS)
			;
	}
	return 0;
}

int sensor_start(void)
{
	return sensor_write(&SET_UP[WRITES - 1]);
}
