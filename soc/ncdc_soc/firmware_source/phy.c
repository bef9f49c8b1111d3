#include "phy.h"

#include <stdbool.h>

#include "hw.h"
#include "mdio.h"
#include "uart.h"

#ifdef CSR_MDIO_WIRES
/* Registers that each chip has: IEEE 802.3, clause 22. */
#define CONTROL 0
#define CONTROL_RESET 0x8000u
#define CONTROL_NEGOTIATE 0x1000u
#define CONTROL_NEGOTIATE_ANEW 0x0200u
#define ID 2			/* and 3, whose lowest four bits are the revision */
#define OFFERED 4
#define OFFERED_10_100_FULL 0x0141u
#define OFFERED_1000 9
#define OFFERED_1000_FULL 0x0200u
#define SPEEDS 3		/* 10, 100, 1000 Mbit/s, as the MAC counts them */
#define PAUSE (MILLISECOND_CLOCKS / 5)		/* between two looks while it is searched for */
#define LONG_PAUSE (100 * MILLISECOND_CLOCKS)	/* while it works */

/* A register of a chip's own: some bits become others. If several share an address, `select` is
 * written before, and chooses which is read. */
struct change {
	uint16_t address, select, clear, set;
};

struct kind {
	uint32_t id;
	struct change changes[2];	/* RGMII, which clocks are late */
	uint16_t control;		/* written after them, so that they take effect */
	uint16_t status, link;		/* bits of the status that are set while there is a link */
	uint16_t field, speed[SPEEDS];	/* of the status: the speed with full duplex */
};

/* The clock that we get is always late by the chip, that which we send by it or by the device. */
#define BY_CHIP(bits) (PHY_DELAYS ? (bits) : 0)

static const struct kind KINDS[] = {
	{
		/* Marvell, 88E1111, as Linux's driver of it has them too. */
		.id = 0x01410cc0u,
		.changes = {
			{20, 0, 0x0082, 0x0080 | BY_CHIP(0x0002)},
			{27, 0, 0x000f, 0x000b},	/* RGMII, whatever its jumper says */
		},
		.control = CONTROL_RESET | CONTROL_NEGOTIATE,
		.status = 17, .link = 0x0c00,		/* resolved as well */
		.field = 0xc000, .speed = {0x0000, 0x4000, 0x8000},
	},
	{
		/* Broadcom, B50612D, data sheet B50612D-DS100-R: tables 28, 51, 59, 52. */
		.id = 0x03625e60u,
		.changes = {
			{24, 0x7007, 0x7107, 0x8107},
			{28, 0x0c00, 0x7e00, 0x8c00 | BY_CHIP(0x0200)},
		},
		.control = CONTROL_NEGOTIATE | CONTROL_NEGOTIATE_ANEW,
		.status = 25, .link = 0x8004,		/* negotiated as well */
		.field = 0x0700, .speed = {0x0200, 0x0500, 0x0700},
	},
};

static enum { SEARCHED, RESETS, WORKS } state;
static uint32_t chip = PHY_FIRST;
static const struct kind *kind;
static uint32_t looked;
static uint32_t speed;		/* that was reported last, plus 1; 0: no link */

/* Full duplex only, RGMII with the receive clock late. */
static void set_up(void)
{
	mdio_write(chip, OFFERED, OFFERED_10_100_FULL);
	mdio_write(chip, OFFERED_1000, OFFERED_1000_FULL);
	for (unsigned k = 0; k < sizeof kind->changes / sizeof *kind->changes; ++k) {
		const struct change *c = kind->changes + k;

		if (c->select)
			mdio_write(chip, c->address, c->select);
		mdio_write(chip, c->address,
			   (mdio_read(chip, c->address) & ~(uint32_t)c->clear) | c->set);
	}
	mdio_write(chip, CONTROL, kind->control);
	state = RESETS;
}

static void search(void)
{
	uint32_t id = mdio_read(chip, ID) << 16 | mdio_read(chip, ID + 1);

	for (unsigned k = 0; k < sizeof KINDS / sizeof *KINDS; ++k)
		if ((id & ~15u) == KINDS[k].id) {
			kind = KINDS + k;
			set_up();
			return;
		}
	chip = chip == PHY_LAST ? PHY_FIRST : chip + 1;
}

static void look(void)
{
	static const char *const NAMES[SPEEDS] = {"10", "100", "1000"};
	uint32_t status = mdio_read(chip, kind->status), now = 0;

	if ((status & kind->link) == kind->link)
		for (unsigned k = 0; k < SPEEDS; ++k)
			if ((status & kind->field) == kind->speed[k])
				now = k + 1;
	if (now == speed)
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
