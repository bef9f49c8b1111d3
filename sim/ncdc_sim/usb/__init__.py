"""USB by an FTDI chip in simulation: its model, its bus, a host."""
