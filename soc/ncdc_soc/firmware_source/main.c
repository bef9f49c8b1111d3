/* The firmware: one loop, no operating system. */
#include <stdbool.h>

#include "auto.h"
#include "eeprom.h"
#include "eth.h"
#include "gvcp.h"
#include "hw.h"
#include "interrupt.h"
#include "ip.h"
#include "net.h"
#include "phy.h"
#include "sensor.h"
#include "stream.h"
#include "table.h"
#include "uart.h"
#include "view_matrix.h"
#include "watchdog.h"
#include "words.h"

#if SETS_UP
struct setting {
	uint32_t address, value;
};

static const struct setting SETTINGS[] = SYSTEM_SETTINGS;

static void camera_start(void)
{
	for (unsigned k = 0; k < sizeof SETTINGS / sizeof *SETTINGS; ++k)
		reg_write(SETTINGS[k].address, SETTINGS[k].value);
	if (sensor_set_up()) {
		uart_text("sensor: no answer, or another one\n");
		return;
	}
	reg_write(NCDC_RUN, 1);
	reg_write(NCDC_CAMERA_ENABLE, 1);
	if (words_begin() || sensor_start())
		uart_text("sensor: no answer\n");
	else
		uart_text("sensor: started\n");
}

static bool camera_begun(void)
{
	return true;
}
#else
static void camera_start(void)
{
}

/* Another part of the design initialises the sensor; its first frame shows that its bus is free. */
static bool camera_begun(void)
{
	static bool begun;

	if (!begun && interrupt_frames(true))
		begun = !words_begin();
	return begun;
}
#endif

static void camera_poll(void)
{
	static bool loaded;

	if (!camera_begun() || loaded || !sensor_idle())
		return;
	loaded = eeprom_load();
	if (loaded) {
		uart_text("eeprom: ");
		uart_hex(eeprom_status);
		uart_text("\n");
	}
}

/* Called at an exception, after which the processor waits until the watchdog resets all. */
void trapped(uint32_t cause, uint32_t at);

void trapped(uint32_t cause, uint32_t at)
{
	uart_text("exception ");
	uart_hex(cause);
	uart_text(" at ");
	uart_hex(at);
	uart_text("\n");
}

int main(void)
{
	uart_text("NCDC " CONFIG_VERSION "\n");
	stream_begin();
	interrupt_begin();
	camera_start();
	gvcp_begin();
	net_begin();
	/* Not before: the sensor's waits may be long, and its bus has limits of its own. */
	watchdog_begin();
	for (;;) {
		watchdog_feed();
		sensor_poll();
		camera_poll();		/* before who asks for the sensor again and again */
		net_poll();
		stream_poll();
		gvcp_poll();
		table_poll();
		auto_poll();
		view_poll();
		phy_poll();
	}
}
