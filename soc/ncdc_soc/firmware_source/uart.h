/* The serial line: the firmware's log. */
#ifndef UART_H
#define UART_H

#include <stdint.h>

void uart_text(const char *text);
void uart_hex(uint32_t value);
void uart_number(uint32_t value);

#endif
