"""FTDI chips in 245 synchronous FIFO mode: bytes, registers and pictures over USB."""
