/* Registers of an Ethernet chip over its management wires (IEEE 802.3, clause 22). */
#ifndef MDIO_H
#define MDIO_H

#include <stdint.h>

uint32_t mdio_read(uint32_t chip, uint32_t address);
void mdio_write(uint32_t chip, uint32_t address, uint32_t value);

#endif
