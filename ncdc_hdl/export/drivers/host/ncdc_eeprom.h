/* Lens of a camera from the image in its EEPROM; see docs/reference/eeprom.md of the project.
 *
 * The image is checked as a whole before any of it is used: an empty or damaged one, or one of
 * another camera, leaves the built-in lens as it was. */
#ifndef NCDC_EEPROM_H
#define NCDC_EEPROM_H

#include "ncdc.h"

#ifdef __cplusplus
extern "C" {
#endif

enum ncdc_eeprom_result {
    NCDC_EEPROM_OK = 0,
    NCDC_EEPROM_EMPTY,      /* all bytes are equal: it was never written */
    NCDC_EEPROM_MAGIC,      /* it does not begin with NCDE */
    NCDC_EEPROM_VERSION,    /* its layout has another version */
    NCDC_EEPROM_LENGTH,     /* it is shorter or longer than it says */
    NCDC_EEPROM_CHECKSUM,   /* its checksum is wrong */
    NCDC_EEPROM_CONTENT,    /* it holds a value out of range */
    NCDC_EEPROM_NEURONS,    /* it has another number of hidden neurons */
    NCDC_EEPROM_SIZE,       /* it is of another size of picture */
    NCDC_EEPROM_KIND        /* it has other formats, grid points, interpolation or tan-sigmoid */
};

/* Memory for a lens from an EEPROM: as many values and spans as the built-in lens has. */
struct ncdc_eeprom_lens {
    struct ncdc_lens lens;
    char digest[13], serial[33];
    struct ncdc_value *values;
    uint32_t *valid_rows;
};

/* For a program that reads a chip byte by byte: bytes of the image that begins with the
 * NCDC_EEPROM_HEAD bytes at `head`, NCDC_EEPROM_HEAD if it says less, 0 if no image begins there. */
#define NCDC_EEPROM_HEAD 10u
uint32_t ncdc_eeprom_length(const uint8_t *head);

/* Read the `bytes` bytes of `image` into `into`, whose `values` and `valid_rows` point to memory
 * for as many as `built_in` has. That lens gives the sizes and all that the image does not hold;
 * `into->lens` may then be given to ncdc_load(). Unless the result is NCDC_EEPROM_OK, `into->lens`
 * is not to be used. */
enum ncdc_eeprom_result ncdc_eeprom_read(const uint8_t *image, uint32_t bytes,
                                         const struct ncdc_lens *built_in,
                                         struct ncdc_eeprom_lens *into);

#ifdef __cplusplus
}
#endif

#endif
