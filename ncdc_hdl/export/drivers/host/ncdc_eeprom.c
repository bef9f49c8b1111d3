#include "ncdc_eeprom.h"

/* Byte offsets in the image. */
enum {
    VERSION = 4, NEURONS = 5, FLAGS = 6, PATTERN = 7, LENGTH = 8, SIZES = 10, FILL = 18, DIGEST = 22,
    SERIAL = 28, KIND = 60, PARAMETERS = 82
};
enum { SERIAL_BYTES = 32, CHECKSUM_BYTES = 4 };
/* Formats among those of the image. */
enum { HIDDEN_WEIGHT = 1, HIDDEN_BIAS = 2, OUTPUT_WEIGHT = 5, OUTPUT_BIAS = 6, SKIP_WEIGHT = 8 };
enum { LAYOUT = 1, PATTERNS = 5, SPANS = 4 };

static uint32_t number(const uint8_t *at, uint32_t bytes)
{
    uint32_t value = 0;

    while (bytes--)
        value = value << 8 | at[bytes];
    return value;
}

/* CRC-32 as zlib has it. */
static uint32_t checksum(const uint8_t *data, uint32_t bytes)
{
    uint32_t crc = 0xFFFFFFFFu;
    int k;

    while (bytes--) {
        crc ^= *data++;
        for (k = 0; k < 8; ++k)
            crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    return ~crc;
}

static int equal(const uint8_t *a, const uint8_t *b, uint32_t bytes)
{
    while (bytes--)
        if (*a++ != *b++)
            return 0;
    return 1;
}

/* Value of a register of `lens` by its offset; 0 if the lens has none. */
static uint32_t value_of(const struct ncdc_lens *lens, uint32_t offset)
{
    uint32_t k;

    for (k = 0; k < lens->value_count; ++k)
        if (lens->values[k].offset == offset)
            return lens->values[k].value;
    return 0;
}

static int is_image(const uint8_t *image)
{
    return equal(image, (const uint8_t *)"NCDE", VERSION);
}

uint32_t ncdc_eeprom_length(const uint8_t *head)
{
    uint32_t length = number(head + LENGTH, 2);

    if (!is_image(head))
        return 0;
    return length < NCDC_EEPROM_HEAD ? NCDC_EEPROM_HEAD : length;
}

static enum ncdc_eeprom_result checked(const uint8_t *image, uint32_t bytes, uint32_t *length)
{
    uint32_t k;

    for (k = 1; k < bytes && image[k] == image[0]; ++k)
        ;
    if (k >= bytes)
        return NCDC_EEPROM_EMPTY;
    if (bytes < VERSION || !is_image(image))
        return NCDC_EEPROM_MAGIC;
    if (bytes <= VERSION || image[VERSION] != LAYOUT)
        return NCDC_EEPROM_VERSION;
    if (bytes < PARAMETERS)
        return NCDC_EEPROM_LENGTH;
    *length = number(image + LENGTH, 2);
    if (*length > bytes || *length < PARAMETERS + CHECKSUM_BYTES)
        return NCDC_EEPROM_LENGTH;
    *length -= CHECKSUM_BYTES;
    return checksum(image, *length) == number(image + *length, CHECKSUM_BYTES)
        ? NCDC_EEPROM_OK : NCDC_EEPROM_CHECKSUM;
}

/* Whether a parameter fits its format, whose integer and fraction bits are at `format`. */
static int fits(const uint8_t *parameter, const uint8_t *format)
{
    uint32_t value = number(parameter, 4);
    uint32_t width = (uint32_t)((int8_t)format[0] + (int8_t)format[1]);
    uint32_t sign = value >> (width - 1);       /* all ones or zeros with the bits above */

    return sign == 0 || sign == 0xFFFFFFFFu >> (width - 1);
}

/* Whether the formats of the image have one for the weights of a skip path. */
static int has_skip_format(const uint8_t *image)
{
    const uint8_t *format = image + KIND + 4 + 2 * SKIP_WEIGHT;

    return format[0] || format[1];
}

/* Whether the serial number is printable, and zeros follow it. */
static int serial_fits(const uint8_t *serial)
{
    uint32_t k = 0;

    while (k < SERIAL_BYTES && serial[k] >= 0x20 && serial[k] < 0x7F)
        ++k;
    while (k < SERIAL_BYTES && serial[k] == 0)
        ++k;
    return k == SERIAL_BYTES;
}

/* Whether the parameters, in the order of their registers, fit the formats of the image. */
static int parameters_fit(const uint8_t *image, uint32_t neurons, uint32_t count)
{
    const uint8_t *formats = image + KIND + 4;
    uint32_t k, format;

    for (k = 0; k < count; ++k) {
        if (k < 3 * neurons)
            format = k % 3 < 2 ? HIDDEN_WEIGHT : HIDDEN_BIAS;
        else if (k < 5 * neurons)
            format = OUTPUT_WEIGHT;
        else
            format = k < 5 * neurons + 2 ? OUTPUT_BIAS : SKIP_WEIGHT;
        if (!fits(image + PARAMETERS + 4 * k, formats + 2 * format))
            return 0;
    }
    return 1;
}

/* One change of a valid row: zigzag, seven bits a byte. 0 if it goes on beyond `end`. */
static int change(const uint8_t **at, const uint8_t *end, int32_t *value)
{
    uint32_t found = 0, shift = 0;
    uint8_t byte;

    do {
        if (*at == end || shift > 14)
            return 0;
        byte = *(*at)++;
        found |= (uint32_t)(byte & 0x7F) << shift;
        shift += 7;
    } while (byte & 0x80);
    *value += found & 1 ? -(int32_t)((found + 1) >> 1) : (int32_t)(found >> 1);
    return 1;
}

/* The valid rows of a picture, from the bytes up to `end`; 0 if they do not fit it. */
static int valid_rows(const uint8_t *at, const uint8_t *end, const struct ncdc_lens *lens,
                      uint32_t *rows)
{
    int32_t spans[SPANS] = {0, 0, 0, 0};
    uint32_t row = 0, repeat, k;
    uint8_t head;

    while (row < lens->height) {
        if (at == end)
            return 0;
        head = *at++;
        for (k = 0; k < SPANS; ++k)
            if ((head >> k & 1) && !change(&at, end, &spans[k]))
                return 0;
        for (k = 0; k < SPANS; ++k)
            if (spans[k] < 0 || spans[k] > (int32_t)lens->width || (k & 1 && spans[k] < spans[k - 1]))
                return 0;
        for (repeat = 0; repeat <= (uint32_t)head >> 4; ++repeat, ++row) {
            if (row == lens->height)
                return 0;
            rows[2 * row] = (uint32_t)spans[0] | (uint32_t)spans[1] << 16;
            rows[2 * row + 1] = (uint32_t)spans[2] | (uint32_t)spans[3] << 16;
        }
    }
    return at == end;
}

static void hex(const uint8_t *at, char *text)
{
    uint32_t k;

    for (k = 0; k < 12; ++k)
        text[k] = "0123456789abcdef"[at[k / 2] >> (k & 1 ? 0 : 4) & 15];
    text[12] = 0;
}

enum ncdc_eeprom_result ncdc_eeprom_read(const uint8_t *image, uint32_t bytes,
                                         const struct ncdc_lens *built_in,
                                         struct ncdc_eeprom_lens *into)
{
    uint32_t length = 0, parameters, k;
    enum ncdc_eeprom_result result = checked(image, bytes, &length);

    if (result != NCDC_EEPROM_OK)
        return result;
    if (image[FLAGS] != has_skip_format(image) || image[PATTERN] >= PATTERNS
            || !serial_fits(image + SERIAL))
        return NCDC_EEPROM_CONTENT;
    if (!equal(image + KIND, built_in->kind, NCDC_KIND_BYTES))
        return NCDC_EEPROM_KIND;
    if (image[NEURONS] != built_in->neurons)
        return NCDC_EEPROM_NEURONS;
    if (number(image + SIZES, 2) != built_in->width || number(image + SIZES + 2, 2) != built_in->height
            || number(image + SIZES + 4, 2) != value_of(built_in, NCDC_DISTORTED_WIDTH)
            || number(image + SIZES + 6, 2) != value_of(built_in, NCDC_DISTORTED_HEIGHT))
        return NCDC_EEPROM_SIZE;
    /* Of a neuron two weights, a bias and two weights of the output layer; its biases and skips. */
    parameters = 5 * built_in->neurons + 2 + (image[FLAGS] ? 4 : 0);
    if (PARAMETERS + 4 * parameters > length || built_in->span_count != 2 * built_in->height
            || !parameters_fit(image, built_in->neurons, parameters)
            || !valid_rows(image + PARAMETERS + 4 * parameters, image + length, built_in,
                           into->valid_rows))
        return NCDC_EEPROM_CONTENT;
    into->lens = *built_in;
    for (k = 0; k < built_in->value_count; ++k) {
        into->values[k] = built_in->values[k];
        /* The parameters are the lens's first values, in the same order. */
        if (k < parameters)
            into->values[k].value = number(image + PARAMETERS + 4 * k, 4);
        else if (into->values[k].offset == NCDC_BAYER_PHASE)
            into->values[k].value = image[PATTERN];
        else if (into->values[k].offset == NCDC_FILL)
            into->values[k].value = number(image + FILL, 3);
#ifdef NCDC_PLANE_FOCAL
        /* The image does not state the camera of the lens's picture; that of another lens is wrong. */
        else if (into->values[k].offset >= NCDC_PLANE_FOCAL
                && into->values[k].offset <= NCDC_PLANE_ASPECT)
            into->values[k].value = 0;
#endif
    }
    hex(image + DIGEST, into->digest);
    for (k = 0; k < SERIAL_BYTES; ++k)
        into->serial[k] = (char)image[SERIAL + k];
    into->serial[SERIAL_BYTES] = 0;
    into->lens.digest = into->digest;
    into->lens.values = into->values;
    into->lens.valid_rows = into->valid_rows;
    return NCDC_EEPROM_OK;
}
