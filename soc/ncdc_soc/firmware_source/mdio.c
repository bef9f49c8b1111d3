#include "mdio.h"

#include "hw.h"

#ifdef CSR_MDIO_WIRES
#define MDC 1u
#define ENABLE 2u
#define DATA_SHIFT 2
#define START 1u		/* two bits */
#define READ 2u
#define WRITE 1u
#define TURN 2u			/* two bits before the data of a write */
#define HALF_CLOCKS (CLOCK_HZ / 5000000 + 1)	/* MDC is 2.5 MHz at most */

static void wires(uint32_t value)
{
	uint32_t from = now32();

	reg_write(CSR_MDIO_WIRES, value);
	while (now32() - from < HALF_CLOCKS)
		;
}

/* A bit, which the chip takes with the rising clock; MDIO's level just before. */
static uint32_t bit(uint32_t enable, uint32_t data)
{
	uint32_t value = (enable ? ENABLE : 0) | data << DATA_SHIFT, level;

	wires(value);
	level = reg_read(CSR_MDIO_LEVEL) & 1;
	wires(value | MDC);
	return level;
}

static void send(uint32_t value, unsigned bits)
{
	while (bits--)
		bit(1, value >> bits & 1);
}

static void begin(uint32_t operation, uint32_t chip, uint32_t address)
{
	send(0xffffffff, 32);
	send(START << 2 | operation, 4);
	send(chip << 5 | address, 10);
}

uint32_t mdio_read(uint32_t chip, uint32_t address)
{
	uint32_t value = 0;

	begin(READ, chip, address);
	bit(0, 0);
	for (unsigned k = 0; k < 17; ++k)	/* the chip's 0 of the turn comes first */
		value = value << 1 | bit(0, 0);
	return value & 0xffff;
}

void mdio_write(uint32_t chip, uint32_t address, uint32_t value)
{
	begin(WRITE, chip, address);
	send(TURN, 2);
	send(value, 16);
	bit(0, 0);
}
#endif
