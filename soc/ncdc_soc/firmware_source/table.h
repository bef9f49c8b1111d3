/* Tables I and II over TCP: commands of one byte, with address and value, and pictures. */
#ifndef TABLE_H
#define TABLE_H

#include <stdint.h>

extern uint32_t table_commands;

/* Listens; 0, or -1 without memory. */
int table_begin(void);
void table_poll(void);

#endif
