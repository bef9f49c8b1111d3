/* The machine around the firmware on a PC: registers of plain memory, and a slot for each frame that
 * comes and that is sent. The program that feeds it has reg_read and reg_write, for its own registers. */
#ifndef MACHINE_H
#define MACHINE_H

#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "auto.h"
#include "eeprom.h"
#include "eth.h"
#include "gvcp.h"
#include "hw.h"
#include "interrupt.h"
#include "net.h"
#include "sensor.h"
#include "stream.h"
#include "table.h"
#include "view_matrix.h"
#include "words.h"

#define WORDS 0x20000		/* of the core's registers */

extern uint32_t core[WORDS], slot[ETHMAC_SLOT_BYTES / 4];	/* slot: the frame that comes */
extern uint32_t length;		/* of that frame */
extern uint32_t pending;	/* whether it waits for the firmware */

void machine_begin(void);

/* A turn of the firmware's loop, but for `interrupted`. */
void machine_turn(void);

/* All registers that the program does not answer itself. */
uint32_t machine_read(uint32_t address);
void machine_write(uint32_t address, uint32_t value);

/* Of the program: the firmware sends a frame. */
void sent(const uint8_t *frame, uint32_t size);

#endif
