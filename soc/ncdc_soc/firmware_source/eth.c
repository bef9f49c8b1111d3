#include "eth.h"

#include "hw.h"

#define SHORTEST 60

const struct eth_address ETH_OWN = {CONFIG_MAC};
uint32_t eth_received, eth_sent, eth_dropped;
static uint32_t slot;		/* that is written next */

uint32_t eth_receive(uint32_t *frame)
{
	uint32_t from, length;

	if (!(reg_read(CSR_ETHMAC_SRAM_WRITER_EV_PENDING) & 1))
		return 0;
	from = ETHMAC_RX_BASE + reg_read(CSR_ETHMAC_SRAM_WRITER_SLOT) * ETHMAC_SLOT_BYTES;
	length = reg_read(CSR_ETHMAC_SRAM_WRITER_LENGTH);
	if (length > ETH_LONGEST) {
		++eth_dropped;
		length = 0;
	}
	for (uint32_t k = 0; k < length; k += 4)
		*frame++ = reg_read(from + k);
	reg_write(CSR_ETHMAC_SRAM_WRITER_EV_PENDING, 1);
	if (length)
		++eth_received;
	return length;
}

void eth_send(const uint32_t *frame, uint32_t length)
{
	uint32_t to = ETHMAC_TX_BASE + slot * ETHMAC_SLOT_BYTES;

	if (length > ETH_LONGEST)
		return;
	/* There are two slots: one may still be on its way, the other one is free then. */
	while (!reg_read(CSR_ETHMAC_SRAM_READER_READY) ||
	       reg_read(CSR_ETHMAC_SRAM_READER_LEVEL) > 1)
		;
	for (uint32_t k = 0; k < length; k += 4)
		reg_write(to + k, *frame++);
	for (uint32_t k = (length + 3) & ~3u; k < SHORTEST; k += 4)
		reg_write(to + k, 0);
	reg_write(CSR_ETHMAC_SRAM_READER_SLOT, slot);
	reg_write(CSR_ETHMAC_SRAM_READER_LENGTH, length < SHORTEST ? SHORTEST : length);
	reg_write(CSR_ETHMAC_SRAM_READER_START, 1);
	slot = !slot;
	++eth_sent;
}
