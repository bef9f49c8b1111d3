"""Images of EEPROMs, good ones and damaged ones, for all that reads them: Python, C, firmware."""

import struct
import zlib

from cameras import barrel_descriptor
from devices import SIZE
from ncdc_spec.eeprom import pack

__all__ = ["BUILT_IN", "DAMAGED", "GOOD", "OTHER"]

BUILT_IN = barrel_descriptor(SIZE, SIZE)
"""Lens that the hardware is made for."""

OTHER = barrel_descriptor(SIZE, SIZE, seed=9, strength=0.12, bayer="GBRG", fill=(1, 2, 250))
GOOD = pack("A0017", OTHER)
_ROWS = 82 + 4 * (5 * OTHER.hidden_neurons + 2)     # offset of the valid rows


def _summed(content):
    """The image with a checksum that is right again."""
    return content[:-4] + struct.pack("<I", zlib.crc32(content[:-4]))


def _changed(at, *values):
    """The good image with other bytes from ``at`` on, and the checksum right."""
    return _summed(GOOD[:at] + bytes(values) + GOOD[at + len(values):])


def _shortened(size):
    """The good image without some bytes of its rows; length and checksum are right."""
    content = GOOD[:-4 - size] + bytes(4)
    return _summed(content[:8] + struct.pack("<H", len(content)) + content[10:])


def _lengthened():
    content = GOOD[:-4] + bytes(8)
    return _summed(content[:8] + struct.pack("<H", len(content)) + content[10:])


def _other(corrected=SIZE, distorted=SIZE, hidden_neurons=3):
    return pack("A", barrel_descriptor(corrected, distorted, hidden_neurons=hidden_neurons))


# By name: the bytes, and why they are rejected. Offsets as in docs/reference/eeprom.md.
DAMAGED = {
    "all zeros": (bytes(4096), "EMPTY"), "all ones": (b"\xff" * 4096, "EMPTY"),
    "nothing": (b"", "EMPTY"), "another file": (b"GIF89a" + bytes(200), "MAGIC"),
    "bytes swapped": (GOOD[3::-1] + GOOD[4:], "MAGIC"), "three bytes": (b"NCD", "MAGIC"),
    "no version": (b"NCDE", "VERSION"),
    "a later version": (_changed(4, 2), "VERSION"), "only the header": (GOOD[:60], "LENGTH"),
    "cut": (GOOD[:-1], "LENGTH"), "a length of zero": (_changed(8, 0, 0), "LENGTH"),
    "a length of 81": (_changed(8, 81, 0), "LENGTH"),
    "too long": (_changed(8, 255, 255), "LENGTH"),
    "a bit of a weight": (GOOD[:90] + bytes([GOOD[90] ^ 4]) + GOOD[91:], "CHECKSUM"),
    "a wrong checksum": (GOOD[:-1] + bytes([GOOD[-1] ^ 1]), "CHECKSUM"),
    "unknown flags": (_changed(6, 2), "CONTENT"),
    "a skip path without a format": (_changed(6, 1), "CONTENT"),
    "a serial number with a line break": (_changed(30, 10), "CONTENT"),
    "a serial number that goes on after a zero": (_changed(59, 65), "CONTENT"),
    "no such filter": (_changed(7, 5), "CONTENT"),
    "a weight out of range": (_changed(82, 0, 0, 0, 1), "CONTENT"),
    "rows cut": (_shortened(1), "CONTENT"), "a byte after the rows": (_lengthened(), "CONTENT"),
    "a span that ends beyond the picture": (_changed(_ROWS, 0x02, 0x82, 0x01), "CONTENT"),
    "more neurons": (_other(hidden_neurons=4), "NEURONS"),
    "a larger picture": (_other(corrected=(72, 48)), "SIZE"),
    "a larger sensor": (_other(distorted=(72, 48)), "SIZE"),
    "another interpolation": (_changed(60, 1), "KIND"),
    "another tan-sigmoid": (_changed(62, 2), "KIND"),
}
