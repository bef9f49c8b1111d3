"""Register accesses as bytes on a serial line.

A request is a letter, a word address of two bytes, the word of a write, and a check; the answer a
letter, the word of a read, and a check. Numbers have their upper byte first; the check is a CRC of
the bytes before it.
"""

__all__ = ["BAD", "CRC", "READ", "READ_DONE", "WRITE", "WRITE_DONE", "crc8", "read_request",
           "write_request"]

READ, WRITE = ord("R"), ord("W")
READ_DONE, WRITE_DONE, BAD = ord("r"), ord("w"), ord("?")
CRC = {"polynomial": 0x07, "initial": 0xFF}
"""CRC of eight bits, the upper bit of a byte first, without reflection or inversion."""


def crc8(data):
    """The check of ``data``, bytes."""
    value = CRC["initial"]
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value << 1 ^ (CRC["polynomial"] if value & 0x80 else 0)
            value &= 0xFF
    return value


def _checked(data):
    return data + bytes([crc8(data)])


def read_request(address):
    """Bytes that ask for the word at a word ``address``."""
    return _checked(bytes([READ]) + address.to_bytes(2, "big"))


def write_request(address, word):
    """Bytes that write ``word`` to a word ``address``."""
    return _checked(bytes([WRITE]) + address.to_bytes(2, "big") + word.to_bytes(4, "big"))
