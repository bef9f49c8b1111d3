"""Layouts between the parts of the CSI-2 receiver."""

from amaranth.lib import data, wiring
from amaranth.lib.wiring import Out

__all__ = ["BYTES", "FAULTS", "HEADER", "LANE", "LANES", "SETTINGS", "payload", "rest_shape",
           "words"]

LANES = (1, 2, 4)

LANE = wiring.Signature({"data": Out(8), "active": Out(1)})
"""A lane without word alignment: eight bits of each byte clock, the first one lowest, and whether
the lane is in high-speed mode and settled."""

BYTES = wiring.Signature({"data": Out(8), "valid": Out(1), "active": Out(1)})
"""A lane with word alignment. ``valid`` is high from the byte after the sync byte to the end of
the burst. ``active`` is high during the burst, sync byte or not. In the terms of the PHY protocol
interface: RxDataHS, RxValidHS and RxActiveHS."""

SETTINGS = data.StructLayout({"channel": 2, "type": 6})
"""Virtual channel of the frames, and data type of their rows, 0x10 or more. RAW10 and RAW12 are
unpacked. Each byte of another type is a sample."""

HEADER = data.StructLayout({"type": 6, "channel": 2, "count": 16})
"""Header of a packet without its ECC; ``count`` is the number of bytes of a payload."""

FAULTS = data.StructLayout({
    "unaligned": 1,     # a burst in which some lane had no sync byte, or too late
    "corrected": 1,     # one wrong bit in a header, which is corrected: the frame stays good
    "header": 1,        # a header with more wrong bits; its packet is dropped
    "checksum": 1,      # the checksum of a row
    "cut": 1,           # a burst ended before its header, or the row in it, was complete
    "length": 1,        # a row whose bytes are no whole groups of samples
    "order": 1,         # a frame in a frame, an end without a start, a row out of a frame, no row
})
"""What may be wrong; each is high for a clock."""


def words(lanes):
    """Signature of aligned bytes, one of each lane, the first one lowest.

    ``valid`` is high during a burst, and low for a clock at least between two bursts.
    """
    return wiring.Signature({"data": Out(8 * lanes), "valid": Out(1)})


def rest_shape(lanes):
    """Shape of a number modulo ``lanes``, of one bit at least."""
    return range(max(lanes, 2))


def payload(lanes):
    """Signature of the bytes of a row, in words of the lanes.

    ``start`` is high for a clock before the first word. ``last`` is high with the last word, and
    ``rest`` is the number of bytes in it modulo ``lanes``.
    """
    return wiring.Signature({"data": Out(8 * lanes), "start": Out(1), "valid": Out(1),
                             "last": Out(1), "rest": Out(rest_shape(lanes))})
