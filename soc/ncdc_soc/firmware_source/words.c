#include "words.h"

#include "hw.h"
#include "interrupt.h"
#include "sensor.h"
#include "view_matrix.h"

#define PAGE 0xf000u		/* the system's words; the sensor's are below */

bool words_streaming;
uint32_t words_dropped, words_torn;
uint32_t words_changed;
static bool corrected = true;
static uint32_t rate = RATE_TENTHS;

CONFIG_CHOICES
const struct part feature_parts[] = CONFIG_PARTS;
static const struct feature FEATURES[] = CONFIG_FEATURES;
static const uint16_t FIELD[] = CONFIG_FIELD;	/* words from FIELD_FIRST on */

/* Registers of the sensor that features are in are cached, so that reading them takes no time on the
 * I2C bus. */
static const uint16_t CACHED[] = SENSOR_CACHED;

#define CACHED_COUNT (sizeof CACHED / sizeof *CACHED)

static uint16_t copies[CACHED_COUNT];

int words_begin(void)
{
	for (unsigned k = 0; k < CACHED_COUNT; ++k) {
		int32_t value = sensor_read(CACHED[k]);

		if (value < 0)
			return -1;
		copies[k] = (uint16_t)value;
	}
	return 0;
}

struct view words_view(void)
{
	struct view view = {!corrected, CORRECTED_WIDTH, CORRECTED_HEIGHT, CORRECTED_SIZE,
			    CORRECTED_PFNC, CORRECTED_MRAW};

	if (!corrected)
		view = (struct view){true, RAW_WIDTH, RAW_HEIGHT, RAW_WIDTH * RAW_HEIGHT, RAW_PFNC,
				     RAW_MRAW};
	return view;
}

uint32_t words_frame_clocks(void)
{
	return (uint32_t)(10ull * CLOCK_HZ / rate);
}

/* Where the sensor's register is cached; 0: it is not. */
static uint16_t *cached(uint32_t address)
{
	for (unsigned k = 0; k < CACHED_COUNT; ++k)
		if (CACHED[k] == address)
			return &copies[k];
	return 0;
}

static uint32_t page_read(uint32_t address)
{
	struct view view = words_view();

	switch (address) {
	case WORD_SOURCE: return corrected;
	case WORD_WIDTH: case WORD_WIDTH_MAX: return view.width;
	case WORD_HEIGHT: case WORD_HEIGHT_MAX: return view.height;
	case WORD_FORMAT: return view.mraw;
	case WORD_FRAME_RATE: return rate;
	case WORD_DROPPED_UPPER: return words_dropped >> 16;
	case WORD_DROPPED_LOWER: return words_dropped & 0xffff;
	case WORD_TORN_UPPER: return words_torn >> 16;
	case WORD_TORN_LOWER: return words_torn & 0xffff;
	case WORD_LINE_TIME_UPPER: return LINE_TIME_NS >> 16;
	case WORD_LINE_TIME_LOWER: return LINE_TIME_NS & 0xffff;
	case WORD_STREAMING: return words_streaming;
	case WORD_FRAMES: return interrupt_frames(view.raw) & 0xffff;
	case WORD_ABILITIES: return ABILITIES;
	case WORD_PAN: case WORD_TILT: case WORD_ROLL: case WORD_ZOOM: return view_read(address);
	case WORD_VIEW_FOCAL_UPPER: return view_focal() >> 16;
	case WORD_VIEW_FOCAL_LOWER: return view_focal() & 0xffff;
	}
	if (address - FIELD_FIRST < sizeof FIELD / sizeof *FIELD)
		return FIELD[address - FIELD_FIRST];
	return 0;	/* also of offsets, number of the lens, of the last lens */
}

bool word_read(uint32_t address, uint32_t *value)
{
	const uint16_t *copy = cached(address);

	*value = 0;
	if (address >= PAGE)
		*value = page_read(address);
	else if (copy)
		*value = *copy;
	else if (address <= SENSOR_LAST)
		return sensor_ask(false, address, value) != SENSOR_UNDER_WAY;
	return true;
}

static enum refusal write_page(uint32_t address, uint32_t value)
{
	switch (address) {
	case WORD_SOURCE:
		if (value > 1)
			return BAD_VALUE;
		corrected = value;
		return DONE;
	case WORD_FORMAT:
		if (value != RAW_MRAW && value != CORRECTED_MRAW)
			return BAD_VALUE;
		corrected = value == CORRECTED_MRAW;
		return DONE;
	case WORD_FRAME_RATE:
		if (value < 1 || value > RATE_TENTHS_MAX)
			return BAD_VALUE;
		rate = value;
		return DONE;
	case WORD_WIDTH: case WORD_HEIGHT: case WORD_OFFSET_X: case WORD_OFFSET_Y: case WORD_LENS:
		return BAD_VALUE;	/* one size, one lens: there is no other value */
	case WORD_PAN: case WORD_TILT: case WORD_ROLL: case WORD_ZOOM:
		return view_write(address, value);
	}
	return READ_ONLY;
}

/* Whether users may write this to the sensor's register: none of these changes size, position or
 * clock of the frame, which the corrector relies on. */
static enum refusal user_writes(uint32_t address, uint32_t value)
{
	static const struct {
		uint16_t address, mask, low, high;
	} USER[] = SENSOR_USER;
	enum refusal refusal = READ_ONLY;

	for (unsigned k = 0; k < sizeof USER / sizeof *USER; ++k) {
		uint32_t part = value & USER[k].mask;

		if (USER[k].address != address)
			continue;
		if (part >= USER[k].low && part <= USER[k].high && !(value >> SENSOR_VALUE_BITS))
			return DONE;
		refusal = BAD_VALUE;
	}
	return refusal;
}

static enum refusal write_sensor(uint32_t address, uint32_t value)
{
	uint16_t *copy = cached(address);
	enum refusal refusal = user_writes(address, value);

	if (refusal)
		return refusal;
	switch (sensor_ask(true, address, &value)) {
	case SENSOR_UNDER_WAY: return UNDER_WAY;
	case SENSOR_SILENT: return NO_ANSWER;
	case SENSOR_DONE: break;
	}
	if (copy)
		*copy = (uint16_t)value;
	words_changed = interrupt_frames(true);
	return DONE;
}

enum refusal word_write(uint32_t address, uint32_t value)
{
	const uint16_t *copy = cached(address);

	/* What is there already is not written, as far as that is known without the bus. */
	if (address >= PAGE ? page_read(address) == value : copy && *copy == value)
		return DONE;
	if (words_streaming && (address == WORD_SOURCE || address == WORD_FORMAT))
		return LOCKED;
	if (auto_locks(address))
		return LOCKED;
	if (copy && auto_writes())
		return UNDER_WAY;
	return address >= PAGE ? write_page(address, value) : write_sensor(address, value);
}

const struct feature *feature_at(uint32_t address)
{
	/* They lie one after the other. */
	uint32_t k = (address - GVCP_FEATURE_BASE) / 4;

	return address % 4 == 0 && k < sizeof FEATURES / sizeof *FEATURES ? &FEATURES[k] : 0;
}

const struct feature *feature_of(enum feature_id id)
{
	return &FEATURES[id];
}

bool feature_in(enum feature_id id, uint32_t address)
{
	const struct part *part = &feature_parts[FEATURES[id].first];

	for (unsigned k = 0; k < FEATURES[id].parts; ++k)
		if (part[k].address == address)
			return true;
	return false;
}

/* The word of a feature: of the page, or cached, so that it is there at once. */
static uint32_t word(uint32_t address)
{
	uint32_t value;

	word_read(address, &value);
	return value;
}

static uint32_t mask_of(const struct part *part)
{
	return ((1u << part->width) - 1) << part->shift;
}

uint32_t feature_read(const struct feature *one)
{
	const struct part *part = &feature_parts[one->first];
	uint32_t value = 0;

	for (unsigned k = 0; k < one->parts; ++k, ++part)
		value |= (word(part->address) & mask_of(part)) >> part->shift << part->low;
	if (one->low < 0)
		return (uint32_t)(int16_t)value;	/* signed numbers are in one word */
	if (one->id == FEATURE_Gain)
		return gain_eighths(value);
	for (unsigned k = 0; k < one->count; ++k)
		if (one->choices[k].word == value)
			return one->choices[k].value;
	return value;
}

/* Writes a feature's words by `write`, those that change. */
static enum refusal put(const struct feature *one, uint32_t value,
			enum refusal (*write)(uint32_t address, uint32_t value))
{
	const struct part *part = &feature_parts[one->first];
	enum refusal refusal = DONE;

	for (unsigned k = 0; k < one->parts && !refusal; ++k, ++part) {
		uint32_t mask = mask_of(part), before = word(part->address);
		uint32_t after = (before & ~mask) | (value >> part->low << part->shift & mask);

		if (after != before)
			refusal = write(part->address, after);
	}
	return refusal;
}

bool feature_takes(const struct feature *one, uint32_t value)
{
	if (one->low < 0)
		return (int32_t)value >= one->low && (int32_t)value <= (int32_t)one->high;
	return value >= (uint32_t)one->low && value <= one->high;
}

enum refusal feature_write(const struct feature *one, uint32_t value)
{
	if (one->count) {
		unsigned k = 0;

		while (k < one->count && one->choices[k].value != value)
			++k;
		if (k == one->count)
			return BAD_VALUE;
		value = one->choices[k].word;
	} else if (!feature_takes(one, value)) {
		return BAD_VALUE;
	}
	return put(one, one->id == FEATURE_Gain ? gain_number(value) : value, word_write);
}

struct exposure words_exposure(void)
{
	uint32_t lines = feature_read(feature_of(FEATURE_ExposureTime));

	/* What the sensor takes for less. */
	return (struct exposure){lines > AUTO_LINES_MIN ? lines : AUTO_LINES_MIN,
				 feature_read(feature_of(FEATURE_Gain))};
}

bool words_expose(const struct exposure *to, const struct limits *limits)
{
	return !(limits->exposure &&
		 put(feature_of(FEATURE_ExposureTime), to->lines, write_sensor) == UNDER_WAY) &&
	       !(limits->gain && put(feature_of(FEATURE_Gain), gain_number(to->gain),
				     write_sensor) == UNDER_WAY);
}
