"""Boards: pins, clocks and memory, and the Quartus projects made from them."""
