#include "phy.h"

#include <stdbool.h>

#include "hw.h"
#include "mdio.h"
#include "uart.h"

#ifdef CSR_MDIO_WIRES
/* Marvell, 88E1111: registers, as Linux's driver of it has them too. */
#define CONTROL 0
#define CONTROL_RESET 0x8000u
#define CONTROL_NEGOTIATE 0x1000u
#define ID 2			/* and 3, whose lowest four bits are the revision */
#define MARVELL_88E1111 0x01410cc0u
#define OFFERED 4
#define OFFERED_10_100_FULL 0x0141u
#define OFFERED_1000 9
#define OFFERED_1000_FULL 0x0200u
#define STATUS 17
#define STATUS_SPEED_SHIFT 14	/* 0, 1, 2: 10, 100, 1000 Mbit/s, as the MAC counts them */
#define STATUS_RESOLVED 0x0800u
#define STATUS_LINK 0x0400u
#define EXTENDED_CONTROL 20
#define RECEIVE_LATE 0x0080u	/* the clock that we get comes 2 ns behind the data */
#define TRANSMIT_LATE 0x0002u	/* so does the one that we send: the device does it */
#define EXTENDED_STATUS 27
#define MODE 0x000fu
#define MODE_RGMII 0x000bu
#define CHIPS 32
#define PAUSE (MILLISECOND_CLOCKS / 5)		/* between two looks while it is searched for */
#define LONG_PAUSE (100 * MILLISECOND_CLOCKS)	/* while it works */

static enum { SEARCHED, RESETS, WORKS } state;
static uint32_t chip;
static uint32_t looked;
static uint32_t speed;		/* that was told last, plus 1; 0: no link */

/* Full duplex only, RGMII with the receive clock late: all of it counts behind a reset. */
static void set_up(void)
{
	mdio_write(chip, OFFERED, OFFERED_10_100_FULL);
	mdio_write(chip, OFFERED_1000, OFFERED_1000_FULL);
	mdio_write(chip, EXTENDED_CONTROL,
		   (mdio_read(chip, EXTENDED_CONTROL) | RECEIVE_LATE) & ~TRANSMIT_LATE);
	mdio_write(chip, EXTENDED_STATUS,
		   (mdio_read(chip, EXTENDED_STATUS) & ~MODE) | MODE_RGMII);
	mdio_write(chip, CONTROL, CONTROL_RESET | CONTROL_NEGOTIATE);
	state = RESETS;
}

static void search(void)
{
	uint32_t id = mdio_read(chip, ID) << 16 | mdio_read(chip, ID + 1);

	if ((id & ~15u) == MARVELL_88E1111)
		set_up();
	else
		chip = (chip + 1) % CHIPS;
}

static void look(void)
{
	static const char *const NAMES[] = {"10", "100", "1000"};
	uint32_t status = mdio_read(chip, STATUS), now = 0;

	if (status & STATUS_LINK && status & STATUS_RESOLVED)
		now = (status >> STATUS_SPEED_SHIFT) + 1;
	if (now == speed || now > 3)
		return;
	speed = now;
	if (!now) {
		uart_text("no link\n");
		return;
	}
	reg_write(CSR_ETHPHY_SPEED, now - 1);
	uart_text("link: ");
	uart_text(NAMES[now - 1]);
	uart_text(" Mbit/s\n");
}

void phy_poll(void)
{
	if (now32() - looked < (speed ? LONG_PAUSE : PAUSE))
		return;
	looked = now32();
	if (state == SEARCHED)
		search();
	else if (state == WORKS)
		look();
	else if (!(mdio_read(chip, CONTROL) & CONTROL_RESET))
		state = WORKS;
}
#else
void phy_poll(void)
{
}
#endif
