/* GVCP: the control protocol on UDP port 3956. Answered before anything else that comes. */
#ifndef GVCP_H
#define GVCP_H

#include <stdbool.h>

#include "ip.h"

#define GVCP_PORT 3956u

/* Before the first frame comes: all registers as they are without a controller. */
void gvcp_begin(void);

/* Answers a frame, if it is a datagram for the port; false otherwise. */
bool gvcp_frame(const uint8_t *frame, uint32_t length);

/* Ends the command that waited for the sensor's bus, and the control of who is silent. */
void gvcp_poll(void);

extern uint32_t gvcp_commands;

#endif
