/* Driver of the NCDC corrector; see docs/reference/drivers.md of the project.
 *
 * Registers are reached through two functions of the user. Offsets are in bytes, accesses are of
 * 32 bits. */
#ifndef NCDC_H
#define NCDC_H

#include <stdint.h>

#include "ncdc_registers.h"

#ifdef __cplusplus
extern "C" {
#endif

/* One corrector: access to it. `context` is passed to both functions. */
struct ncdc {
    uint32_t (*read)(void *context, uint32_t offset);
    void (*write)(void *context, uint32_t offset, uint32_t value);
    void *context;
};

struct ncdc_value {
    uint32_t offset, value;
};

#define NCDC_KIND_BYTES 22u

/* All data of a camera but the addresses of its frames: network, geometry, valid rows, split of the
 * cache. */
struct ncdc_lens {
    const char *digest;             /* of the descriptor, 12 hex digits */
    uint8_t kind[NCDC_KIND_BYTES];  /* number formats and such, as in an EEPROM: ncdc_eeprom.h */
    uint32_t neurons;
    uint32_t interpolation;         /* bit of NCDC_CAPABILITIES that it needs */
    uint32_t width, height;         /* of the corrected image */
    uint32_t source_bytes;          /* bytes read of a raw frame: see NCDC_SOURCE_BEYOND */
    uint32_t target_bytes;          /* bytes of a corrected frame */
    const struct ncdc_value *values;
    uint32_t value_count;
    const uint32_t *valid_rows;     /* start | stop << 16 of both spans of every row */
    uint32_t span_count;
};

/* Memory for a frame: byte address, and bytes that the corrector may use. */
struct ncdc_buffer {
    uint32_t address, bytes;
};

/* Counters of the last complete frame. */
struct ncdc_counters {
#define NCDC_COUNTER_MEMBER(member, offset) uint32_t member;
    NCDC_EACH_COUNTER(NCDC_COUNTER_MEMBER)
#undef NCDC_COUNTER_MEMBER
};

#ifdef NCDC_VIEWS
/* A view of a list: its matrix, row by row, as for the registers NCDC_VIEW_X_U to NCDC_VIEW_Z_0;
 * the cache's split and columns of a strip; pixels; code of NCDC_OUTPUT_FORMAT; bytes from the
 * start of the buffer to the first pixel, and from row to row (0: without a gap). */
struct ncdc_view {
    int32_t matrix[9];
    uint32_t split, strip, width, height, format, offset, pitch;
};
#endif

enum ncdc_result {
    NCDC_OK = 0,
    NCDC_ERROR_ID,          /* no corrector answers */
    NCDC_ERROR_NEURONS,     /* the lens has another number of hidden neurons */
    NCDC_ERROR_COMMITTED,   /* a commit waits for its frame boundary: nothing was written */
    NCDC_ERROR_REFUSED,     /* the corrector ignored a write */
    NCDC_ERROR_TIMEOUT,     /* no frame was complete in time */
    NCDC_ERROR_ABORTED,     /* the frame that is complete lacks pixels */
    NCDC_ERROR_VERSION,     /* the corrector has registers that this driver does not support */
    NCDC_ERROR_SIZE,        /* the lens is larger than the corrector, or no multiple of its lanes;
                             * or there are more matrices, or another step, than it has */
    NCDC_ERROR_ALIGNMENT,   /* a buffer does not begin on a memory word */
    NCDC_ERROR_ROOM,        /* a buffer is too small for a frame of the lens */
    NCDC_ERROR_FAULT,       /* the corrector rejected a frame, or an access outside its buffers */
    NCDC_ERROR_INTERPOLATION, /* the lens is for an interpolation that the corrector lacks */
    NCDC_ERROR_FIXED_LENS   /* the corrector has another lens, which is fixed */
};

/* Does a corrector answer, with registers that this driver supports? */
enum ncdc_result ncdc_check(const struct ncdc *device);

/* May another lens than that of DIGEST be loaded? A reset does not clear the valid rows: if
 * this is 1 after a reset, load a lens before the next frame. */
int ncdc_altered(const struct ncdc *device);

/* Write a lens to the set that the next commit makes active, its valid rows to the bank that is
 * not in use. A frame that runs meanwhile does not use it. The lens comes with one view, its own
 * picture: load it first, then write views and matrices. A corrector with a fixed lens accepts
 * that one alone, and nothing is written. */
enum ncdc_result ncdc_load(const struct ncdc *device, const struct ncdc_lens *lens);

/* Memory of the raw and of the corrected frame of `lens`, also for the next commit. Nothing
 * outside is read or written, for any values of the registers. A corrector with a video stream
 * ignores `target`, which may be 0. */
enum ncdc_result ncdc_place(const struct ncdc *device, const struct ncdc_lens *lens,
                            const struct ncdc_buffer *source, const struct ncdc_buffer *target);

#ifdef NCDC_VIEWS
/* Views that each start makes of one raw frame, from the next commit on. All write to the buffer of
 * ncdc_place(), which must have the bytes that they need. NCDC_ERROR_SIZE if there are none, or more
 * than the corrector makes, or a pitch has more than 16 bits. */
enum ncdc_result ncdc_views(const struct ncdc *device, const struct ncdc_view *views,
                            uint32_t count);
#endif

#ifdef NCDC_VIEW_ROWS
/* A table of `count` matrices down the raw frame, for the next commit; 0: none. The nine numbers
 * of each are row by row, see docs/explanation/view.md. Matrix k belongs to the raw row
 * k * (8 << step). A frame that runs meanwhile does not use them. */
enum ncdc_result ncdc_view_rows(const struct ncdc *device, uint32_t step,
                                const int32_t (*matrices)[9], uint32_t count);
#endif

/* Make what was written active at the next frame boundary. */
void ncdc_commit(const struct ncdc *device);

/* Correct a frame; while one runs, another one may be started. */
void ncdc_start(const struct ncdc *device);

/* Both, in one register write. */
void ncdc_commit_and_start(const struct ncdc *device);

/* End the frame that runs, soon; ncdc_wait() returns when its last word is in memory. */
void ncdc_abort(const struct ncdc *device);

/* Wait until a frame is complete, reading STATUS at most `polls` times (0: for ever), and clear
 * DONE, so that the next call waits for the next frame. */
enum ncdc_result ncdc_wait(const struct ncdc *device, uint32_t polls);

/* The same, but call `idle` with `context` after each poll without a frame, until it returns
 * other than 0: then NCDC_ERROR_TIMEOUT. For a system that sleeps or does other work meanwhile. */
enum ncdc_result ncdc_wait_calling(const struct ncdc *device, int (*idle)(void *context),
                                   void *context);

/* Enable or disable `irq` at the end of a frame. */
void ncdc_enable_interrupt(const struct ncdc *device, int enable);

/* For an interrupt handler: did this corrector interrupt? If so `irq` falls, DONE is
 * cleared, and `result` is what ncdc_wait() returns. */
int ncdc_interrupted(const struct ncdc *device, enum ncdc_result *result);

/* Bits NCDC_FAULT_... of the faults since the last call, which clears them. */
uint32_t ncdc_faults(const struct ncdc *device);

void ncdc_read_counters(const struct ncdc *device, struct ncdc_counters *counters);

#ifdef __cplusplus
}
#endif

#endif
