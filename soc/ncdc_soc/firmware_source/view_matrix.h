/* Pan, tilt, roll and zoom: words of Table I, and the corrector's matrix that is made of them. As
 * ncdc_spec.view_matrix and ncdc_spec.view, in numbers of 64 bits: a register may differ by one. */
#ifndef VIEW_MATRIX_H
#define VIEW_MATRIX_H

#include <stdbool.h>
#include <stdint.h>

#include "words.h"

/* The word at an address of the page, WORD_PAN to WORD_ZOOM; 0 without a view. */
uint32_t view_read(uint32_t address);

/* Focal length at a zoom of 1 in hundredths of a pixel; 0 if the lens does not state it. */
uint32_t view_focal(void);

/* Looks elsewhere from one of the next frames on; BAD_VALUE also if the matrix would not fit the
 * registers. */
enum refusal view_write(uint32_t address, uint32_t value);

/* Another lens is committed, for which the matrix is to be made anew. */
void view_renew(void);

/* Writes and commits a matrix that waits, all of it at once. */
void view_poll(void);

/* A client writes the corrector's register at a byte offset: until its commit the view waits, so that
 * no part of a lens becomes active. False: a commit of the view is under way, and the same is to be
 * asked again. */
bool view_lets(uint32_t offset, uint32_t value);

/* The client is gone, and what it has not committed. */
void view_forget_client(void);

#endif
