#include "machine.h"

uint32_t core[WORDS], slot[ETHMAC_SLOT_BYTES / 4], length, pending;
static uint32_t csr[0x4000], out[2 * ETHMAC_SLOT_BYTES / 4];

static uint32_t *csr_at(uint32_t address)
{
	return &csr[(address - CSR_CTRL_RESET) / 4];
}

uint32_t machine_read(uint32_t address)
{
	switch (address) {
	case NCDC_CAMERA_STATUS: return NCDC_CAMERA_STATUS_CORRECTED_FRAME |
					NCDC_CAMERA_STATUS_RAW_FRAME;
	case CSR_ETHMAC_SRAM_WRITER_EV_PENDING: return pending;
	case CSR_ETHMAC_SRAM_WRITER_LENGTH: return length;
	case CSR_ETHMAC_SRAM_WRITER_SLOT: return 0;
	case CSR_ETHMAC_SRAM_READER_READY: return 1;
	case CSR_ETHMAC_SRAM_READER_LEVEL: return 0;
	case CSR_UART_TXFULL: return 0;
	}
	if (address - ETHMAC_RX_BASE < sizeof slot)
		return slot[(address - ETHMAC_RX_BASE) / 4];
	if (address - FRAMES_BASE < 0x10000000)
		return address;
	if (address - NCDC_BASE < sizeof core)
		return core[(address - NCDC_BASE) / 4];
	if (address - CSR_CTRL_RESET < sizeof csr)
		return *csr_at(address);
	fprintf(stderr, "nothing to read at %#x\n", address);
	abort();
}

void machine_write(uint32_t address, uint32_t value)
{
	if (address % 4) {
		fprintf(stderr, "%#x is no word\n", address);
		abort();
	}
	if (address == CSR_ETHMAC_SRAM_WRITER_EV_PENDING)
		pending = 0;
	else if (address == CSR_ETHMAC_SRAM_READER_START)
		sent((const uint8_t *)out + *csr_at(CSR_ETHMAC_SRAM_READER_SLOT) * ETHMAC_SLOT_BYTES,
		     *csr_at(CSR_ETHMAC_SRAM_READER_LENGTH));
	else if (address - ETHMAC_TX_BASE < sizeof out)
		out[(address - ETHMAC_TX_BASE) / 4] = value;
	else if (address - NCDC_BASE < sizeof core)
		core[(address - NCDC_BASE) / 4] = value;
	else if (address - CSR_CTRL_RESET < sizeof csr)
		*csr_at(address) = value;
	else {
		fprintf(stderr, "nothing to write at %#x\n", address);
		abort();
	}
}

/* The processor's interrupts: the programs call `interrupted` themselves. */
void interrupts_let(uint32_t lines)
{
	(void)lines;
}

void machine_begin(void)
{
	interrupt_begin();
	words_begin();
	gvcp_begin();
	net_begin();
	while (!eeprom_load())
		;
}

void machine_turn(void)
{
	sensor_poll();
	net_poll();
	stream_poll();
	gvcp_poll();
	table_poll();
	auto_poll();
	view_poll();
}
