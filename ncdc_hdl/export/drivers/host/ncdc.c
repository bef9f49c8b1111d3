#include "ncdc.h"

static uint32_t get(const struct ncdc *device, uint32_t offset)
{
    return device->read(device->context, offset);
}

static void put(const struct ncdc *device, uint32_t offset, uint32_t value)
{
    device->write(device->context, offset, value);
}

/* Whether the corrector ignored a write since the last call. */
static enum ncdc_result rejected(const struct ncdc *device)
{
    if (!(get(device, NCDC_STATUS) & NCDC_STATUS_REFUSED))
        return NCDC_OK;
    put(device, NCDC_STATUS, NCDC_STATUS_REFUSED);
    return NCDC_ERROR_REFUSED;
}

/* The bits of `word` under `mask`, a run of ones, as a number. */
static uint32_t field(uint32_t word, uint32_t mask)
{
    return (word & mask) / (mask & (0u - mask));
}

enum ncdc_result ncdc_check(const struct ncdc *device)
{
    uint32_t word;

    if (get(device, NCDC_ID) != NCDC_ID_VALUE)
        return NCDC_ERROR_ID;
    word = get(device, NCDC_CAPABILITIES);
    return field(word, NCDC_CAPABILITIES_VERSION) == NCDC_VERSION ? NCDC_OK : NCDC_ERROR_VERSION;
}

int ncdc_altered(const struct ncdc *device)
{
    return get(device, NCDC_ALTERED) != 0;
}

/* The first 32 bits of a lens's digest, as in DIGEST. */
static uint32_t digest(const struct ncdc_lens *lens)
{
    uint32_t word = 0, k;

    for (k = 0; k < 8; ++k) {
        char digit = lens->digest[k];

        word = word << 4 | (uint32_t)(digit <= '9' ? digit - '0' : digit - 'a' + 10);
    }
    return word;
}

enum ncdc_result ncdc_load(const struct ncdc *device, const struct ncdc_lens *lens)
{
    uint32_t status = get(device, NCDC_STATUS);
    uint32_t bank = status & NCDC_STATUS_BANK ? 0 : 1;
    uint32_t largest = get(device, NCDC_LARGEST);
    uint32_t capabilities = get(device, NCDC_CAPABILITIES);
    uint32_t k;

    if (capabilities & NCDC_CAPABILITIES_FIXED_LENS)
        return get(device, NCDC_DIGEST) == digest(lens) ? NCDC_OK : NCDC_ERROR_FIXED_LENS;
    if (get(device, NCDC_NEURONS) != lens->neurons)
        return NCDC_ERROR_NEURONS;
    if (!(capabilities & lens->interpolation))
        return NCDC_ERROR_INTERPOLATION;
    if (lens->width > field(largest, NCDC_LARGEST_WIDTH)
            || lens->height > field(largest, NCDC_LARGEST_HEIGHT)
            || lens->width % field(capabilities, NCDC_CAPABILITIES_LANES))
        return NCDC_ERROR_SIZE;
    if (status & NCDC_STATUS_COMMITTED)
        return NCDC_ERROR_COMMITTED;
    for (k = 0; k < lens->value_count; ++k)
        put(device, lens->values[k].offset, lens->values[k].value);
    put(device, NCDC_VALID_WINDOW, bank);
    for (k = 0; k < lens->span_count; ++k)
        put(device, NCDC_VALID_ROWS + 4 * k, lens->valid_rows[k]);
    put(device, NCDC_VALID_BANK, bank);
    return rejected(device);
}

/* Whether a frame of `bytes` bytes fits the buffer, in a memory with words of `word` bytes. */
static enum ncdc_result fits(const struct ncdc_buffer *buffer, uint32_t bytes, uint32_t word)
{
    if (buffer->address % word)
        return NCDC_ERROR_ALIGNMENT;
    /* The limit must be below 4 GB. */
    return buffer->bytes < bytes || buffer->bytes > UINT32_MAX - buffer->address ? NCDC_ERROR_ROOM
                                                                                 : NCDC_OK;
}

enum ncdc_result ncdc_place(const struct ncdc *device, const struct ncdc_lens *lens,
                            const struct ncdc_buffer *source, const struct ncdc_buffer *target)
{
    uint32_t capabilities = get(device, NCDC_CAPABILITIES);
    uint32_t word = field(capabilities, NCDC_CAPABILITIES_WORD);
    int stream = (capabilities & NCDC_CAPABILITIES_STREAM) != 0;
    enum ncdc_result result = fits(source, lens->source_bytes, word);

    if (result == NCDC_OK && !stream)
        result = fits(target, lens->target_bytes, word);
    if (result != NCDC_OK)
        return result;
    if (get(device, NCDC_STATUS) & NCDC_STATUS_COMMITTED)
        return NCDC_ERROR_COMMITTED;
    put(device, NCDC_SOURCE_BASE, source->address);
    put(device, NCDC_SOURCE_LIMIT, source->address + source->bytes);
    if (!stream) {
        put(device, NCDC_TARGET_BASE, target->address);
        put(device, NCDC_TARGET_LIMIT, target->address + target->bytes);
    }
    return rejected(device);
}

#ifdef NCDC_VIEWS
enum ncdc_result ncdc_views(const struct ncdc *device, const struct ncdc_view *views,
                            uint32_t count)
{
    uint32_t k, j;

    if (!count || count > field(get(device, NCDC_VIEWS_STATE), NCDC_VIEWS_STATE_MAX))
        return NCDC_ERROR_SIZE;
    for (k = 0; k < count; ++k)
        if (views[k].pitch > UINT16_MAX)
            return NCDC_ERROR_SIZE;     /* the register would keep its lowest bits */
    if (get(device, NCDC_STATUS) & NCDC_STATUS_COMMITTED)
        return NCDC_ERROR_COMMITTED;
    for (k = 0; k < count; ++k) {
        uint32_t entry = (NCDC_VIEW1_X_U - NCDC_VIEW0_X_U) * k;

        for (j = 0; j < 9; ++j)
            put(device, NCDC_VIEW0_X_U + entry + 4 * j, (uint32_t)views[k].matrix[j]);
        put(device, NCDC_VIEW0_SPLIT + entry, views[k].split);
        put(device, NCDC_VIEW0_STRIP + entry, views[k].strip);
        put(device, NCDC_VIEW0_WIDTH + entry, views[k].width);
        put(device, NCDC_VIEW0_HEIGHT + entry, views[k].height);
        put(device, NCDC_VIEW0_FORMAT + entry, views[k].format);
        put(device, NCDC_VIEW0_OFFSET + entry, views[k].offset);
        put(device, NCDC_VIEW0_PITCH + entry, views[k].pitch);
    }
    put(device, NCDC_VIEWS, count);
    return rejected(device);
}
#endif

#ifdef NCDC_VIEW_ROWS
enum ncdc_result ncdc_view_rows(const struct ncdc *device, uint32_t step,
                                const int32_t (*matrices)[9], uint32_t count)
{
    uint32_t status, bank, table, k, number;

    /* A commit that waits could still change the bank in use. */
    if (get(device, NCDC_STATUS) & NCDC_STATUS_COMMITTED)
        return NCDC_ERROR_COMMITTED;
    status = get(device, NCDC_VIEW_ROWS_STATUS);
    bank = status & NCDC_VIEW_ROWS_STATUS_BANK ? 0 : 1;
    table = NCDC_VIEW_MATRICES + 4096 * bank;
    if (count > field(status, NCDC_VIEW_ROWS_STATUS_LIMIT) || step > 3)
        return NCDC_ERROR_SIZE;
    for (k = 0; k < count; ++k)
        for (number = 0; number < 9; ++number)
            put(device, table + 64 * k + 16 * (number / 3) + 4 * (number % 3),
                (uint32_t)matrices[k][number]);
    put(device, NCDC_VIEW_ROWS, count);
    put(device, NCDC_VIEW_ROWS_STEP, step);
    put(device, NCDC_VIEW_ROWS_BANK, bank);
    return rejected(device);
}
#endif

void ncdc_commit(const struct ncdc *device)
{
    put(device, NCDC_CTRL, NCDC_CTRL_COMMIT);
}

void ncdc_start(const struct ncdc *device)
{
    put(device, NCDC_CTRL, NCDC_CTRL_START);
}

void ncdc_commit_and_start(const struct ncdc *device)
{
    put(device, NCDC_CTRL, NCDC_CTRL_COMMIT | NCDC_CTRL_START);
}

void ncdc_abort(const struct ncdc *device)
{
    put(device, NCDC_CTRL, NCDC_CTRL_ABORT);
}

/* Clear DONE, and return the result of the frame. */
static enum ncdc_result ended(const struct ncdc *device, uint32_t status)
{
    put(device, NCDC_STATUS, NCDC_STATUS_DONE);
    if (status & NCDC_STATUS_FAULT)
        return NCDC_ERROR_FAULT;
    return status & NCDC_STATUS_ABORTED ? NCDC_ERROR_ABORTED : NCDC_OK;
}

enum ncdc_result ncdc_wait(const struct ncdc *device, uint32_t polls)
{
    uint32_t left = polls;
    uint32_t status = get(device, NCDC_STATUS);

    while (!(status & NCDC_STATUS_DONE)) {
        if (polls && !--left)
            return NCDC_ERROR_TIMEOUT;
        status = get(device, NCDC_STATUS);
    }
    return ended(device, status);
}

enum ncdc_result ncdc_wait_calling(const struct ncdc *device, int (*idle)(void *context),
                                   void *context)
{
    uint32_t status = get(device, NCDC_STATUS);

    while (!(status & NCDC_STATUS_DONE)) {
        if (idle(context))
            return NCDC_ERROR_TIMEOUT;
        status = get(device, NCDC_STATUS);
    }
    return ended(device, status);
}

void ncdc_enable_interrupt(const struct ncdc *device, int enable)
{
    put(device, NCDC_IRQ_ENABLE, enable != 0);
}

int ncdc_interrupted(const struct ncdc *device, enum ncdc_result *result)
{
    uint32_t status = get(device, NCDC_STATUS);

    if (!(status & NCDC_STATUS_DONE) || !get(device, NCDC_IRQ_ENABLE))
        return 0;
    *result = ended(device, status);
    return 1;
}

uint32_t ncdc_faults(const struct ncdc *device)
{
    uint32_t faults = get(device, NCDC_FAULT);

    put(device, NCDC_FAULT, faults);
    return faults;
}

void ncdc_read_counters(const struct ncdc *device, struct ncdc_counters *counters)
{
#define NCDC_COUNTER_READ(member, offset) counters->member = get(device, offset);
    NCDC_EACH_COUNTER(NCDC_COUNTER_READ)
#undef NCDC_COUNTER_READ
}
