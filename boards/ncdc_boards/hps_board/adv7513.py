"""Configuration of the HDMI transmitter ADV7513, as writes over I2C."""

__all__ = ["I2C_ADDRESS", "WRITES"]

I2C_ADDRESS = 0x39
WRITES = (
    (0xD6, 0xC0, "a monitor counts as plugged in, so that it may be plugged in later"),
    (0x41, 0x10, "powered up; bit 4 is fixed"),
    (0x98, 0x03, "fixed"), (0x9A, 0xE0, "fixed"), (0x9C, 0x30, "fixed"), (0x9D, 0x61, "fixed"),
    (0xA2, 0xA4, "fixed"), (0xA3, 0xA4, "fixed"), (0xE0, 0xD0, "fixed"), (0xF9, 0x00, "fixed"),
    (0x15, 0x00, "input of 24 bits, RGB 4:4:4, with separate syncs"),
    (0x16, 0x30, "8 bits a colour, output RGB 4:4:4"),
    (0x18, 0x46, "no conversion of colours"),
    (0xAF, 0x04, "DVI, not encrypted: a picture without sound"),
)
"""(register, value, meaning). Analog Devices, ADV7513 Programming Guide, revision B, quick start
guide and register map: "fixed" are values that it requires without an explanation."""
