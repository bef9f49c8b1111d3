/* Table II: the newest picture with a header in front, over TCP. */
#ifndef MRAW_H
#define MRAW_H

#include <stdbool.h>
#include <stdint.h>

#include "frames.h"
#include "lwip/tcp.h"

/* A connection's package. */
struct mraw {
	enum { MRAW_NONE, MRAW_ASKED, MRAW_SENDS } state;
	uint32_t sent;		/* bytes that lwIP has taken */
	uint32_t moved_ms;	/* when it took the last of them */
	bool watched;		/* others wait: since when, and how many bytes lwIP had taken */
	uint32_t watched_ms, watched_from;
	uint32_t number;	/* of the frame that was sent last */
};

extern uint32_t mraw_packages;		/* sent to their end */

/* Claims the newest frame; false if there is none, or one is being sent. */
bool mraw_claim(void);

/* Claims the newest raw frame for statistics; false if there is none, or a package is being sent. Until
 * it is given back no package begins. */
bool mraw_borrow(struct frame *frame);

/* Whether it was held until now. */
bool mraw_give_back(void);

/* Begins a package that was asked for, of the frame that was claimed. */
void mraw_begin(struct mraw *mraw);

/* Its user has left. */
void mraw_forget(struct mraw *mraw);

/* Gives lwIP some bytes. False if the connection has to be closed: it takes none for too long, or
 * less than the minimum rate while others wait, or the frame was taken away. */
bool mraw_send(struct mraw *mraw, struct tcp_pcb *pcb);

#endif
