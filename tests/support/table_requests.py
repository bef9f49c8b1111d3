"""Requests of Table I that every device of ours answers alike, in the order in which they are sent.

Left out is what devices have or have not: other sizes, offsets, frame rates and lenses, mirrors of
the sensor, and what its other registers hold.
"""

from ncdc_spec.pixel_formats import PIXEL_FORMATS
from ncdc_spec.protocols.features import system_word
from ncdc_spec.protocols.table_one import READ, SYSTEM_WORDS, WRITE
from ncdc_spec.sensors import mt9p031

__all__ = ["table_requests"]

_SENSOR = mt9p031.SENSOR
# What differs from device to device, or with time.
_OWN = {"FRAME_RATE", "LINE_TIME_UPPER", "LINE_TIME_LOWER", "DROPPED_UPPER", "DROPPED_LOWER",
        "TORN_UPPER", "TORN_LOWER", "FRAMES", "ABILITIES"}


def table_requests():
    """List of (code, address, value)."""
    words = [word.address for word in SYSTEM_WORDS if word.name not in _OWN]
    made = [(READ, address, 0) for address in (
        *words, 0xF000 + len(SYSTEM_WORDS), 0xF7FF, 0xFFFF, 0x100, 0x1234, 0xEFFF,
        mt9p031.CHIP_VERSION)]
    made += _registers() + _formats()
    # Read-only, or nothing at all: the answer says what is there.
    for word in SYSTEM_WORDS:
        if word.access == "ro" and word.name not in _OWN:
            made += [(WRITE, word.address, value) for value in (0, 1, 0xFFFF)]
    for address in (0xF000 + len(SYSTEM_WORDS), 0xFFFF, 0x100, 0x1234, 0xEFFF,
                    mt9p031.CHIP_VERSION):
        made += [(WRITE, address, value) for value in (1, 0xFFFF)]
    for name in ("WIDTH", "HEIGHT"):        # no picture has such sizes
        made += [(WRITE, system_word(name), value) for value in (0, 1, 7, 9, 0xFFFF)]
    for name in ("OFFSET_X", "OFFSET_Y", "LENS"):
        made += [(WRITE, system_word(name), value) for value in (0, 1, 0xFFFF)]
    return made + [(READ, address, 0) for address in words]


def _registers():
    """Every register that users write, at the limits of its ranges and one beyond."""
    made = []
    for one in _SENSOR.user_registers:
        ends = {end + step for pair in one.ranges for end in pair for step in (-1, 0, 1)}
        for value in sorted(ends | {0, 1, 0x7FFF, 0xFFFF} | {one.mask + 1}):
            if 0 <= value <= 0xFFFF:
                made += [(WRITE, one.address, value), (READ, one.address, value ^ 0xFFFF)]
        # A value that all devices have from here on.
        made.append((WRITE, one.address, one.ranges[0][0]))
    return made


def _formats():
    """Raw or corrected, by either word; at the end corrected."""
    source, form = system_word("SOURCE"), system_word("FORMAT")
    made = []
    for value in (0, 1, 2, 0xFFFF, 0):
        made += [(WRITE, source, value), (READ, form, 0), (READ, source, 0)]
    codes = {one.mraw for one in PIXEL_FORMATS if one.raw} | {0, 0x77, 0x100, 0xFFFF}
    for value in sorted(codes):
        made += [(WRITE, form, value), (READ, source, 0)]
    return [*made, (WRITE, source, 1), (READ, form, 0)]
