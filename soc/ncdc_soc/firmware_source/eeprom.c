#include "eeprom.h"

#include <string.h>

#include "hw.h"
#include "lwip/mem.h"
#include "ncdc_eeprom.h"
#include "sensor.h"
#include "view_matrix.h"
#include "watchdog.h"

#define FIRST 0x50		/* address of the first chip */
#define CHIPS 8
#define TRIES (12 * CHIPS)	/* of an address: 10 ms, in which a chip ends a write */
#define HEAD NCDC_EEPROM_HEAD	/* bytes of the image that are read first */
#define POINTER_MAX 2		/* bytes of an address in a chip */
#define SPACE (MEM_SIZE / 8 * 7)	/* of lwIP's heap, which has few users yet */
#define LAST (NCDC_I2C_COMMAND_NACK | NCDC_I2C_COMMAND_STOP)

enum { NO_CHIP, RESULTS };	/* then the results of the driver */

/* Registers of the network, whose values the image has, and those whose values the built-in lens has. */
static const uint16_t PARAMETERS[] = CONFIG_LENS_PARAMETERS;
static const struct ncdc_value VALUES[] = CONFIG_LENS_VALUES;

#define PARAMETER_COUNT (sizeof PARAMETERS / sizeof *PARAMETERS)
#define VALUE_COUNT (PARAMETER_COUNT + sizeof VALUES / sizeof *VALUES)

/* Its values are in memory when they are needed. */
static const struct ncdc_lens BUILT_IN = {
	.kind = CONFIG_LENS_KIND,
	.neurons = LENS_NEURONS,
	.interpolation = LENS_INTERPOLATION,
	.width = CORRECTED_WIDTH,
	.height = CORRECTED_HEIGHT,
	.value_count = VALUE_COUNT,
	.span_count = 2 * CORRECTED_HEIGHT,
};

/* What lwIP lends for a while. */
struct memory {
	struct ncdc_value values[VALUE_COUNT];
	uint32_t rows[2 * CORRECTED_HEIGHT];
	uint8_t image[];
};

uint32_t eeprom_status = NO_CHIP;

/* Carries out a command of the I2C controller: the byte received, or -1 if that fails. */
static int i2c(uint32_t command)
{
	uint32_t result;

	watchdog_feed();
	reg_write(NCDC_I2C_COMMAND, command);
	do
		result = reg_read(NCDC_I2C_RESULT);
	while (result & NCDC_I2C_RESULT_BUSY);
	return result & I2C_FAILED ? -1 : (int)(result & NCDC_I2C_RESULT_DATA);
}

static bool send(uint32_t byte, uint32_t more)
{
	return i2c(byte | NCDC_I2C_COMMAND_WRITE | more) >= 0;
}

/* Receives bytes in a row; `last` ends the last one. */
static bool take(uint8_t *to, uint32_t count, uint32_t last)
{
	while (count--) {
		int byte = i2c(NCDC_I2C_COMMAND_READ | (count ? 0 : last));

		if (byte < 0)
			return false;
		*to++ = (uint8_t)byte;
	}
	return true;
}

/* Begins to read a chip from its beginning on, whose addresses have so many bytes. */
static bool begin(uint32_t chip, unsigned pointer)
{
	bool answers = send(chip << 1, NCDC_I2C_COMMAND_START);

	while (answers && pointer--)
		answers = send(0, 0);
	return answers && send(chip << 1 | 1, NCDC_I2C_COMMAND_START);
}

static uint32_t core_read(void *context, uint32_t offset)
{
	(void)context;
	return reg_read(NCDC_BASE + offset);
}

static void core_write(void *context, uint32_t offset, uint32_t value)
{
	(void)context;
	reg_write(NCDC_BASE + offset, value);
}

/* Loads the lens of a whole image; false: a client has just loaded another one, or a write was rejected,
 * perhaps before. */
static bool load(struct memory *memory, uint32_t length)
{
	static const struct ncdc device = {.read = core_read, .write = core_write};
	struct ncdc_eeprom_lens from = {.values = memory->values, .valid_rows = memory->rows};
	struct ncdc_lens built_in = BUILT_IN;
	enum ncdc_eeprom_result found;
	enum ncdc_result loaded;

	for (unsigned k = 0; k < PARAMETER_COUNT; ++k)
		memory->values[k].offset = PARAMETERS[k];
	memcpy(memory->values + PARAMETER_COUNT, VALUES, sizeof VALUES);
	built_in.values = memory->values;
	found = ncdc_eeprom_read(memory->image, length, &built_in, &from);
	loaded = found ? NCDC_OK : ncdc_load(&device, &from.lens);
	if (loaded == NCDC_ERROR_COMMITTED || loaded == NCDC_ERROR_REFUSED)
		return false;
	if (loaded)
		found = NCDC_EEPROM_KIND;
	else if (!found) {
		ncdc_commit(&device);
		view_renew();
	}
	eeprom_status = RESULTS + found;
	return true;
}

/* Receives the rest of an image, and loads it; false: not now. */
static bool go_on(uint8_t *head, uint32_t length)
{
	struct memory *memory = mem_malloc((mem_size_t)(sizeof *memory + length));
	bool done;

	if (!memory) {
		take(head, 1, LAST);
		return false;
	}
	memcpy(memory->image, head, HEAD);
	done = take(memory->image + HEAD, length - HEAD, LAST) && load(memory, length);
	mem_free(memory);
	return done;
}

/* Loads the lens of a chip; false: not now. */
static bool load_from(uint32_t chip)
{
	uint8_t head[HEAD + 1];
	uint32_t length = 0;

	/* First a byte of address: to a chip that takes one, the second would be data. */
	for (unsigned pointer = 1; !length && pointer <= POINTER_MAX; ++pointer) {
		if (!begin(chip, pointer) || !take(head, HEAD, 0)) {
			i2c(NCDC_I2C_COMMAND_STOP);
			return false;
		}
		length = ncdc_eeprom_length(head);
		if (length > HEAD && sizeof(struct memory) + length <= SPACE)
			return go_on(head, length);
		if (!take(head + HEAD, 1, LAST))
			return false;
	}
	/* These are too few for an image: the driver says what is wrong. */
	eeprom_status = RESULTS + ncdc_eeprom_read(head, sizeof head, &BUILT_IN, 0);
	return true;
}

/* One address at a time: the network does not wait for a chip that is not there. */
bool eeprom_load(void)
{
	static unsigned tried;
	uint32_t chip = FIRST + tried % CHIPS;

	return (send(chip << 1, NCDC_I2C_COMMAND_START | NCDC_I2C_COMMAND_STOP) && load_from(chip)) ||
	       ++tried == TRIES;
}
