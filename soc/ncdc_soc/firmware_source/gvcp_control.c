#include "gvcp_control.h"

#include "hw.h"
#include "stream.h"
#include "view_matrix.h"
#include "words.h"

struct control control = {.heartbeat = HEARTBEAT_MS};

bool control_is(const struct udp_path *peer)
{
	return control.controlled && control.controller.ip == peer->ip &&
	       control.controller.port == peer->port;
}

void control_release(void)
{
	stream_stop();
	control.controlled = control.acquiring = false;
	control.heartbeat = HEARTBEAT_MS;
	control.privilege = control.port = control.delay = control.address = 0;
	control.tl_locked = control.single = control.triggered = control.configuration = 0;
	control.packet_size = PACKET_DO_NOT_FRAGMENT | stream_packet_size(1500);
	words_streaming = false;
	view_forget_client();
}

void control_poll(void)
{
	/* A stream of one picture ends by itself; its packets can still be sent again. */
	if (control.acquiring && stream_ended()) {
		control.acquiring = false;
		words_streaming = control.tl_locked;
	}
	if (control.controlled &&
	    now64() - control.heard > (uint64_t)control.heartbeat * (CLOCK_HZ / 1000))
		control_release();
}
