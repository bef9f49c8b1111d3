/* Access to the registers for ncdc.h through mapped memory on Linux. Map 0 of /dev/uioN at offset 0,
 * or the address of the registers in /dev/mem. */
#ifndef NCDC_MAPPED_H
#define NCDC_MAPPED_H

#include <fcntl.h>
#include <stdint.h>
#include <sys/mman.h>
#include <unistd.h>

#include "ncdc.h"

static inline uint32_t ncdc_mapped_read(void *base, uint32_t offset)
{
    return *(volatile uint32_t *)((char *)base + offset);
}

static inline void ncdc_mapped_write(void *base, uint32_t offset, uint32_t value)
{
    *(volatile uint32_t *)((char *)base + offset) = value;
}

/* Map the registers. Returns a descriptor of the file, to wait for interrupts with, or -1. */
static inline int ncdc_map(struct ncdc *device, const char *path, off_t offset)
{
    int file = open(path, O_RDWR | O_SYNC);
    void *base;

    if (file < 0)
        return -1;
    base = mmap(0, 1u << 16, PROT_READ | PROT_WRITE, MAP_SHARED, file, offset);
    if (base == MAP_FAILED) {
        close(file);
        return -1;
    }
    device->read = ncdc_mapped_read;
    device->write = ncdc_mapped_write;
    device->context = base;
    return file;
}

/* For ncdc_wait_calling(), with a UIO device's descriptor as `context`: enable its interrupt and
 * sleep until it comes. */
static inline int ncdc_uio_sleep(void *context)
{
    uint32_t one = 1;
    int file = *(int *)context;

    return write(file, &one, sizeof one) != sizeof one || read(file, &one, sizeof one) != sizeof one;
}

#endif
