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
static enum ncdc_result refused(const struct ncdc *device)
{
    if (!(get(device, NCDC_STATUS) & NCDC_STATUS_REFUSED))
        return NCDC_OK;
    put(device, NCDC_STATUS, NCDC_STATUS_REFUSED);
    return NCDC_ERROR_REFUSED;
}

enum ncdc_result ncdc_check(const struct ncdc *device)
{
    return get(device, NCDC_ID) == NCDC_ID_VALUE ? NCDC_OK : NCDC_ERROR_ID;
}

enum ncdc_result ncdc_load(const struct ncdc *device, const struct ncdc_lens *lens)
{
    uint32_t status = get(device, NCDC_STATUS);
    uint32_t bank = status & NCDC_STATUS_BANK ? 0 : 1;
    uint32_t k;

    if (get(device, NCDC_NEURONS) != lens->neurons)
        return NCDC_ERROR_NEURONS;
    if (status & NCDC_STATUS_COMMITTED)
        return NCDC_ERROR_COMMITTED;
    for (k = 0; k < lens->value_count; ++k)
        put(device, lens->values[k].offset, lens->values[k].value);
    put(device, NCDC_VALID_WINDOW, bank);
    for (k = 0; k < lens->span_count; ++k)
        put(device, NCDC_VALID_ROWS + 4 * k, lens->valid_rows[k]);
    put(device, NCDC_VALID_BANK, bank);
    return refused(device);
}

enum ncdc_result ncdc_place(const struct ncdc *device, uint32_t source, uint32_t target)
{
    if (get(device, NCDC_STATUS) & NCDC_STATUS_COMMITTED)
        return NCDC_ERROR_COMMITTED;
    put(device, NCDC_SOURCE_BASE, source);
    put(device, NCDC_TARGET_BASE, target);
    return refused(device);
}

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

enum ncdc_result ncdc_wait(const struct ncdc *device, uint32_t polls)
{
    uint32_t left = polls;
    uint32_t status = get(device, NCDC_STATUS);

    while (!(status & NCDC_STATUS_DONE)) {
        if (polls && !--left)
            return NCDC_ERROR_TIMEOUT;
        status = get(device, NCDC_STATUS);
    }
    put(device, NCDC_STATUS, NCDC_STATUS_DONE);
    return status & NCDC_STATUS_ABORTED ? NCDC_ERROR_ABORTED : NCDC_OK;
}

void ncdc_read_counters(const struct ncdc *device, struct ncdc_counters *counters)
{
#define NCDC_COUNTER_READ(member, offset) counters->member = get(device, offset);
    NCDC_EACH_COUNTER(NCDC_COUNTER_READ)
#undef NCDC_COUNTER_READ
}
