/* The network: what comes is GVCP's, or that of the protocols below it. */
#ifndef NET_H
#define NET_H

#include <stdbool.h>
#include <stdint.h>

void net_begin(void);
void net_poll(void);

/* Gives the device an address, mask and gateway until it is reset. With an address of 0 it looks for
 * one anew, after the next answer. False if no device can have that address. */
bool net_force(uint32_t ip, uint32_t mask, uint32_t gateway);

#endif
