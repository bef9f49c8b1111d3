#include "uart.h"

#include "hw.h"

static void put(char c)
{
	while (reg_read(CSR_UART_TXFULL))
		;
	reg_write(CSR_UART_RXTX, (uint8_t)c);
}

void uart_text(const char *text)
{
	while (*text)
		put(*text++);
}

void uart_hex(uint32_t value)
{
	for (int shift = 28; shift >= 0; shift -= 4)
		put("0123456789abcdef"[value >> shift & 15]);
}

void uart_number(uint32_t value)
{
	if (value >= 10)
		uart_number(value / 10);
	put((char)('0' + value % 10));
}
