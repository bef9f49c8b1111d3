"""Radiona ULX3S: a Lattice ECP5, 32 MB of SDR SDRAM, a GPDI connector; with open tools only."""
