/* The Ethernet chip, if the processor has its management wires. */
#ifndef PHY_H
#define PHY_H

void phy_poll(void);

#endif
