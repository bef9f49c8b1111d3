"""Numbers of MIPI CSI-2 over D-PHY that a sensor, its model and its receiver share."""

from enum import IntEnum

__all__ = ["DataType", "MAX_SKEW", "SAMPLE_BITS_OF", "SYNC_BYTE"]

SYNC_BYTE = 0xB8        # begins the burst of each lane, lowest bit first

MAX_SKEW = 4            # bytes by which the lanes of a burst may differ


class DataType(IntEnum):
    """Data types of packets. Those below 0x10 are short packets, which have no payload."""
    FRAME_START = 0x00
    FRAME_END = 0x01
    LINE_START = 0x02
    LINE_END = 0x03
    NULL = 0x10
    BLANKING = 0x11
    EMBEDDED = 0x12
    RAW8 = 0x2A
    RAW10 = 0x2B
    RAW12 = 0x2C


SAMPLE_BITS_OF = {DataType.RAW8: 8, DataType.RAW10: 10, DataType.RAW12: 12}
"""Bits of a sample of each data type that has samples."""
