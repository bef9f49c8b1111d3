"""Packets of a CSI-2 transmitter, written from the specification apart from the receiver."""

import numpy as np

from ncdc_spec.sensors.csi2 import SAMPLE_BITS_OF, DataType

__all__ = ["checksum", "ecc", "frame_packets", "long_packet", "pack", "short_packet", "with_ecc"]

# Bits of the header that each parity bit is the sum of, as the specification lists them.
_PARITIES = (
    (0, 1, 2, 4, 5, 7, 10, 11, 13, 16, 20, 21, 22, 23),
    (0, 1, 3, 4, 6, 8, 10, 12, 14, 17, 20, 21, 22, 23),
    (0, 2, 3, 5, 6, 9, 11, 12, 15, 18, 20, 21, 22),
    (1, 2, 3, 7, 8, 9, 13, 14, 15, 19, 20, 21, 23),
    (4, 5, 6, 7, 8, 9, 16, 17, 18, 19, 20, 22, 23),
    (*range(10, 20), 21, 22, 23),
)


def ecc(header):
    """Error-correcting code of the three bytes of a header, the fourth byte."""
    bits = int.from_bytes(header, "little")
    return sum((sum(bits >> k & 1 for k in parity) & 1) << number
               for number, parity in enumerate(_PARITIES))


def _crc_of(byte):
    for _ in range(8):
        byte = byte >> 1 ^ (0x8408 if byte & 1 else 0)
    return byte


_CRCS = [_crc_of(byte) for byte in range(256)]


def checksum(payload):
    """Checksum of a payload, as the two bytes that are sent."""
    crc = 0xFFFF
    for byte in payload:
        crc = crc >> 8 ^ _CRCS[(crc ^ byte) & 0xFF]
    return crc.to_bytes(2, "little")


def with_ecc(channel, kind, number):
    """A header of a virtual channel, a data type and a number of 16 bits."""
    header = bytes([channel << 6 | kind, number & 0xFF, number >> 8])
    return header + bytes([ecc(header)])


def short_packet(channel, kind, number=0):
    """A packet without a payload."""
    return with_ecc(channel, kind, number)


def long_packet(channel, kind, payload):
    """A packet with a payload of bytes."""
    return with_ecc(channel, kind, len(payload)) + bytes(payload) + checksum(payload)


def pack(samples, bits):
    """Payload of a row of samples of 8, 10 or 12 bits.

    Raises
    ------
    ValueError
        If the samples are no whole groups.
    """
    samples = np.asarray(samples, np.uint16)
    if bits == 8:
        return samples.astype(np.uint8).tobytes()
    low_bits = bits - 8
    groups = samples.reshape(-1, 8 // low_bits)
    low = np.zeros(len(groups), np.uint16)
    for k, column in enumerate(groups.T):
        low |= (column & (1 << low_bits) - 1) << low_bits * k
    return np.column_stack([groups >> low_bits, low]).astype(np.uint8).tobytes()


def frame_packets(samples, kind=DataType.RAW10, channel=0, number=0, *, embedded=0,
                  line_packets=False):
    """Packets of a frame of ``samples``.

    Parameters
    ----------
    samples : array_like of int
        Rows of samples of as many bits as ``kind`` has.
    kind : DataType
    channel, number : int
        Virtual channel, number of the frame.
    embedded : int
        Rows of embedded data before the first row.
    line_packets : bool
        Whether short packets begin and end each row.
    """
    packets = [short_packet(channel, DataType.FRAME_START, number)]
    packets += [long_packet(channel, DataType.EMBEDDED, bytes(range(7, 27)))
                for _ in range(embedded)]
    for y, row in enumerate(samples, 1):
        rows = [long_packet(channel, kind, pack(row, SAMPLE_BITS_OF[kind]))]
        if line_packets:
            rows = [short_packet(channel, DataType.LINE_START, y), *rows,
                    short_packet(channel, DataType.LINE_END, y)]
        packets += rows
    return [*packets, short_packet(channel, DataType.FRAME_END, number)]
