/* Pictures over GVSP: which frame goes out, its headers, what is sent again. */
#ifndef STREAM_H
#define STREAM_H

#include <stdbool.h>
#include <stdint.h>

#include "eth.h"

#define STREAM_PORT 49152u	/* of UDP, that packets come from */

struct receiver {
	struct eth_address mac;
	uint32_t ip, port, packet_size, delay_clocks;
};

extern uint32_t stream_frames, stream_resends;

/* Largest size of a packet up to `size` that the hardware can make. */
uint32_t stream_packet_size(uint32_t size);

void stream_begin(void);
/* `waits`: each picture waits for a trigger. */
void stream_start(const struct receiver *to, bool single, bool waits);
void stream_trigger(void);
void stream_stop(void);
bool stream_ended(void);	/* it was to be one picture, which has gone */

/* Asks for packets of a picture again. */
void stream_resend(uint32_t block, uint32_t first, uint32_t last);

/* Sends a test packet of that size, if the hardware can make it, unless pictures stream. */
void stream_test(const struct receiver *to, uint32_t size);

void stream_poll(void);

#endif
