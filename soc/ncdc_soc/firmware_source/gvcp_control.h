/* Inside GVCP: who controls the device and what that one has set; reading and writing by address. */
#ifndef GVCP_CONTROL_H
#define GVCP_CONTROL_H

#include <stdbool.h>
#include <stdint.h>

#include "hw.h"
#include "ip.h"

/* Of an acknowledge; UNFINISHED is none: the sensor's bus or a commit is at work. */
enum gvcp_status {
	CONFIG_GVCP_STATUSES, UNFINISHED = 1
};

/* Registers that a controller writes, and the controller. */
struct control {
	struct udp_path controller;	/* while `controlled` */
	bool controlled;
	bool acquiring;
	uint64_t heard;		/* clock of the controller's last command */
	uint64_t stamp;		/* ns, latched */
	uint32_t heartbeat;	/* ms */
	uint32_t privilege, port, delay, address, packet_size;
	uint32_t tl_locked, single, triggered, sensor_address;
	uint32_t configuration;
};

extern struct control control;

/* Whether the device is controlled, and from there. */
bool control_is(const struct udp_path *peer);

/* Ends the control and the stream: all as without a controller. */
void control_release(void);

/* Takes control from a controller that has not been heard of for the heartbeat's time. */
void control_poll(void);

/* The word at an address; a status. */
uint32_t gvcp_read_word(uint32_t address, uint32_t *value);

/* Writes `count` bytes from an address on to `to`, but those that `*done` counts, which it moves; a
 * status. */
uint32_t gvcp_read_memory(uint32_t address, uint32_t count, uint8_t *to, uint32_t *done);

/* Writes a word for `peer`; a status. */
uint32_t gvcp_write_word(uint32_t address, uint32_t value, const struct udp_path *peer);

#endif
