/* The firmware on a PC, at the end of a cable that a test holds: lines of text are its frames.
 *
 * Input, a line each: "f HEX", a frame that comes; "t MS", time that passes; "c CLOCKS", what the clock
 * shows from then on; "l VALUE", what the packetiser's status is. Each is answered by the frames that
 * were sent meanwhile, in hex, by "r VALUE" for packets that the packetiser sends again, "s" for a
 * frame that it sends, and by ".".
 * "b LIGHT" has raw frames show a grey of LIGHT / 65536 for each line of exposure and eighth of gain, as
 * the sensor does: with registers of two frames ago. "p OFFSET VALUE" sets a register of the corrector,
 * of a sum of colours to what it is with gains of 1 at capture;
 * "q OFFSET" asks for it; "e LEVEL LINES GAIN EXPOSURE GAIN LINES" and "w RED GREEN BLUE PIXELS RED GREEN
 * BLUE" ask for what the rules of auto.h say; "i ADDRESS" asks for a register of the sensor. The answer
 * to these begins with "v", in decimal. "k NUMBERS" is a commit of the corrector, with the nine of its
 * matrix.
 * The sensor's registers take what is written; at first they hold what the firmware would set them to.
 * Arguments, if there is an EEPROM: a file of its content, the bytes of an address in it, how often it
 * does not answer at first, how often a commit of another lens is seen to wait, and whether a write was
 * rejected before.
 * A new frame is complete whenever time passes. */
#include "chip.h"
#include "machine.h"

#define TURNS 300		/* of the loop for a frame: more than any answer needs */
#define TURN_CLOCKS 50
#define STEP_MS 5

static uint32_t link_status;
static uint64_t now;

/* The sensor at the I2C bus: the bytes of its registers, whose addresses count on by themselves. */
#define POINTER_BYTES (SENSOR_POINTER_BITS / 8)
#define VALUE_BYTES (SENSOR_VALUE_BITS / 8)

static const struct {
	uint16_t address, value;
	uint32_t wait_us;
} SET_UP[] = SENSOR_SET_UP;

static uint8_t registers[VALUE_BYTES << SENSOR_POINTER_BITS];
static uint32_t i2c_result, i2c_bytes, i2c_at;
static bool i2c_sensor;		/* it is the sensor that was addressed */

static unsigned waiting;	/* reads of STATUS that find another lens committed */
static uint32_t light;		/* 0: raw frames show their addresses */
static uint32_t exposed[3];	/* lines times gain, of the frame that is complete and of the next ones */
static uint32_t balanced[3];	/* gains of capture, likewise */
static uint32_t colours[3];	/* sums of the corrector, if these gains were 1 */

static void hold(uint32_t address, uint32_t value)
{
	for (unsigned k = VALUE_BYTES; k--; value >>= 8)
		registers[VALUE_BYTES * address + k] = (uint8_t)value;
}

static void i2c(uint32_t command)
{
	i2c_result = 0;
	if (command & NCDC_I2C_COMMAND_START)
		i2c_sensor = (command & 0xff) >> 1 == SENSOR_I2C;
	if (chip_i2c(command, &i2c_result))
		return;
	if (!i2c_sensor)
		i2c_result = NCDC_I2C_RESULT_NACK;
	else if (command & NCDC_I2C_COMMAND_START)
		i2c_bytes = 0;
	else if (command & NCDC_I2C_COMMAND_WRITE && ++i2c_bytes <= POINTER_BYTES)
		i2c_at = (i2c_bytes == 1 ? 0 : i2c_at << 8) | (command & 0xff) * VALUE_BYTES;
	else if (command & NCDC_I2C_COMMAND_WRITE)
		registers[i2c_at++ % sizeof registers] = (uint8_t)command;
	else if (command & NCDC_I2C_COMMAND_READ)
		i2c_result = registers[i2c_at++ % sizeof registers];
}

static uint32_t register_at(uint32_t address)
{
	uint32_t value = 0;

	for (unsigned k = 0; k < VALUE_BYTES; ++k)
		value = value << 8 | registers[VALUE_BYTES * address + k];
	return value;
}

/* The number of a feature in the sensor's registers. */
static uint32_t number(enum feature_id id)
{
	const struct part *part = &feature_parts[feature_of(id)->first];
	uint32_t found = 0;

	for (unsigned k = 0; k < feature_of(id)->parts; ++k, ++part)
		found |= (register_at(part->address) >> part->shift & ((1u << part->width) - 1))
			 << part->low;
	return found;
}

static void expose(void)
{
	uint32_t lines = number(FEATURE_ExposureTime);

	exposed[0] = exposed[1];
	exposed[1] = exposed[2];
	exposed[2] = (lines ? lines : 1) * gain_eighths(number(FEATURE_Gain));
}

static uint32_t *system_register(uint32_t address)
{
	return &core[(address - NCDC_BASE) / 4];
}

/* A raw frame has begun; the one before the last one is corrected, and its colours are added up. */
static void balance(void)
{
	balanced[0] = balanced[1];
	balanced[1] = balanced[2];
	balanced[2] = *system_register(NCDC_CAPTURE_GAINS);
	for (unsigned c = 0; c < 3; ++c) {
		uint64_t gain = balanced[0] >> AUTO_RATIO_BITS * c & AUTO_RATIO_MAX;

		core[CORRECTOR_SUMS / 4 + c] = (uint32_t)(colours[c] * gain / AUTO_RATIO_UNITY);
	}
	*system_register(NCDC_CORRECTED_NUMBER) = ++*system_register(NCDC_RAW_BEGUN) - 2;
	++core[CORRECTOR_FRAMES / 4];
}

/* Four samples of the raw frame. */
static uint32_t grey(void)
{
	uint64_t sample = (uint64_t)light * exposed[0] >> 16;

	return (uint32_t)(sample > 255 ? 255 : sample) * 0x01010101u;
}

uint32_t reg_read(uint32_t address)
{
	if (address == NCDC_BASE + NCDC_STATUS && waiting) {
		--waiting;
		return NCDC_STATUS_COMMITTED;
	}
	switch (address) {
	case NCDC_TIME_LOW: return (uint32_t)now;
	case NCDC_TIME_HIGH: return (uint32_t)(now >> 32);
	case NCDC_I2C_RESULT: return i2c_result;
	case NCDC_READER0: case NCDC_READER0 + 4: case NCDC_READER0 + 8: return NCDC_READER0_HELD;
	case LINK_STATUS: return link_status;
	}
	return light && address - FRAMES_BASE < 0x10000000 ? grey() : machine_read(address);
}

static void show_commit(void)
{
	printf("k");
	for (unsigned k = 0; k < 9; ++k)
		printf(" %d", (int)core[CORRECTOR_VIEW / 4 + k]);
	printf("\n");
}

void reg_write(uint32_t address, uint32_t value)
{
	if (address == NCDC_BASE + NCDC_STATUS)
		value = core[NCDC_STATUS / 4] & ~value;
	if (address == NCDC_BASE + CORRECTOR_CTRL && value & CORRECTOR_COMMIT)
		show_commit();
	if (address == LINK_CONTROL && value & LINK_CONTROL_SEND)
		printf("s\n");
	else if (address == LINK_RESEND_LAST)
		printf("r %x\n", (unsigned)value);
	else if (address == NCDC_I2C_COMMAND)
		i2c(value);
	else
		machine_write(address, value);
}

void sent(const uint8_t *frame, uint32_t size)
{
	while (size--)
		printf("%02x", *frame++);
	printf("\n");
}

static void loop(void)
{
	for (unsigned k = 0; k < TURNS; ++k) {
		now += TURN_CLOCKS;
		machine_turn();
	}
}

static void come(const char *hex)
{
	unsigned byte;

	memset(slot, 0, sizeof slot);
	for (length = 0; length < sizeof slot && sscanf(hex + 2 * length, "%2x", &byte) == 1; ++length)
		((uint8_t *)slot)[length] = (uint8_t)byte;
	pending = 1;
	loop();
}

static void pass(uint32_t ms)
{
	for (uint32_t k = 0; k < ms; k += STEP_MS) {
		now += (uint64_t)STEP_MS * (CLOCK_HZ / 1000);
		expose();
		balance();
		interrupted();
		loop();
	}
}

/* What the rules say of numbers in a line. */
static void rules(const char *line)
{
	uint32_t n[7] = {0};

	sscanf(line + 2, "%u %u %u %u %u %u %u", n, n + 1, n + 2, n + 3, n + 4, n + 5, n + 6);
	if (*line == 'e') {
		struct limits limits = {n[3], n[4], n[5]};
		struct exposure found = auto_exposed(n[0], (struct exposure){n[1], n[2]}, &limits);

		printf("v %u %u\n", found.lines, found.gain);
	} else {
		auto_balanced(n, n[3], n + 4);
		printf("v %u %u %u\n", n[4], n[5], n[6]);
	}
}

static void corrector(const char *line)
{
	unsigned offset, value = 0;

	sscanf(line + 2, "%u %u", &offset, &value);
	if (*line == 'p' && offset - CORRECTOR_SUMS < sizeof colours)
		colours[(offset - CORRECTOR_SUMS) / 4] = value;
	else if (*line == 'p')
		core[offset / 4] = value;
	else
		printf("v %u\n", core[offset / 4]);
}

/* What the corrector says of itself. */
static void identify(void)
{
	core[NCDC_NEURONS / 4] = LENS_NEURONS;
	core[NCDC_CAPABILITIES / 4] = LENS_INTERPOLATION |
				      (NCDC_CAPABILITIES_LANES & -NCDC_CAPABILITIES_LANES);
	core[NCDC_LARGEST / 4] = CORRECTED_WIDTH * (NCDC_LARGEST_WIDTH & -NCDC_LARGEST_WIDTH) |
				 CORRECTED_HEIGHT * (NCDC_LARGEST_HEIGHT & -NCDC_LARGEST_HEIGHT);
}

int main(int count, char **arguments)
{
	static char line[2 * ETHMAC_SLOT_BYTES + 8];

	for (unsigned k = 0; k < sizeof SET_UP / sizeof *SET_UP; ++k)
		hold(SET_UP[k].address, SET_UP[k].value);
	hold(SENSOR_ID_ADDRESS, SENSOR_ID);
	for (unsigned c = 0; c < 3; ++c)
		*system_register(NCDC_CAPTURE_GAINS) |= AUTO_RATIO_UNITY << AUTO_RATIO_BITS * c;
	balanced[0] = balanced[1] = balanced[2] = *system_register(NCDC_CAPTURE_GAINS);
	identify();
	if (count == 6) {
		chip_begin(arguments[1], (unsigned)atoi(arguments[2]), (unsigned)atoi(arguments[3]));
		waiting = (unsigned)atoi(arguments[4]);
		core[NCDC_STATUS / 4] = atoi(arguments[5]) ? NCDC_STATUS_REFUSED : 0;
	}
	machine_begin();
	while (fgets(line, sizeof line, stdin)) {
		if (line[0] == 'f')
			come(line + 2);
		else if (line[0] == 't')
			pass((uint32_t)strtoul(line + 2, 0, 10));
		else if (line[0] == 'b')
			light = (uint32_t)strtoul(line + 2, 0, 10);
		else if (line[0] == 'e' || line[0] == 'w')
			rules(line);
		else if (line[0] == 'p' || line[0] == 'q')
			corrector(line);
		else if (line[0] == 'l')
			link_status = (uint32_t)strtoul(line + 2, 0, 0);
		else if (line[0] == 'i')
			printf("v %u\n", register_at((uint32_t)strtoul(line + 2, 0, 10)));
		else if (line[0] == 'c')
			now = strtoull(line + 2, 0, 10);
		printf(".\n");
		fflush(stdout);
	}
	return 0;
}
