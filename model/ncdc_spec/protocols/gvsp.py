"""GVSP: pictures as UDP packets, a leader, numbered payload packets and a trailer, big endian."""

import struct

import numpy as np

__all__ = ["HEADERS_BYTES", "HEADER_FIELDS", "IMAGE", "LEADER", "LEADER_FIELDS", "MAX_PACKET",
           "MIN_PACKET", "PAYLOAD", "PAYLOAD_STEP", "STORED_BLOCKS", "TRAILER", "TRAILER_FIELDS",
           "full_packets", "header", "leader", "packet_size", "payload_packets", "trailer"]

LEADER, TRAILER, PAYLOAD = 1, 2, 3      # the format byte
IMAGE = 0x0001                          # payload type
HEADERS_BYTES = 20 + 8 + 8              # IP, UDP and GVSP, all counted in a packet's size
MIN_PACKET = 576                        # bytes with headers that a client may ask for at least
MAX_PACKET = 16380                      # and at most; a device sends the next smaller it has
STORED_BLOCKS = 2                       # for PACKETRESEND: the picture sent last, the one before
PAYLOAD_STEP = 16                       # bytes of a picture in a packet are a multiple of it

# The packets of a picture: (bytes, meaning) of each field.
HEADER_FIELDS = ((2, "status, 0"), (2, "block: number of the picture, 1 to 65535, then 1 again"),
                 (1, "format: 1 leader, 2 trailer, 3 payload"),
                 (3, "packet number, 0 of the leader"))
LEADER_FIELDS = ((2, "0"), (2, "1: a picture"), (8, "time stamp, ns"), (4, "GVSP code of the pixel "
                 "format"), (4, "width"), (4, "height"), (4, "offset x"), (4, "offset y"), (2, "0"),
                 (2, "0"))
TRAILER_FIELDS = ((2, "0"), (2, "1: a picture"), (4, "height"))

_HEADER = struct.Struct(">HHI")         # status, block, format and packet number
_LEADER = struct.Struct(">HHQIIIIIHH")
_TRAILER = struct.Struct(">HHI")


def header(block, kind, packet, status=0):
    """The eight bytes that begin packet number ``packet`` of a ``block`` (1..65535)."""
    return _HEADER.pack(status, block, kind << 24 | packet)


def leader(block, time_ns, pixel_format, size, offset=(0, 0)):
    """The packet that announces a picture: packet number 0.

    ``size`` and ``offset``: (width, height) and (column, row) in pixels.
    """
    return header(block, LEADER, 0) + _LEADER.pack(0, IMAGE, time_ns, pixel_format.pfnc, *size,
                                                   *offset, 0, 0)


def trailer(block, packet, height):
    """The last packet of a picture; ``packet``: number after that of the last payload packet."""
    return header(block, TRAILER, packet) + _TRAILER.pack(0, IMAGE, height)


def packet_size(asked):
    """The largest size up to ``asked``, in bytes with headers, that a device of ours sends."""
    return (asked - HEADERS_BYTES) // PAYLOAD_STEP * PAYLOAD_STEP + HEADERS_BYTES


def payload_packets(size, packet_size):
    """(payload bytes of a packet, number of packets) of a picture of ``size`` bytes."""
    payload = packet_size - HEADERS_BYTES
    return payload, -(-size // payload)


def full_packets(block, data, payload):
    """The packets of a picture that are full: uint8 (n, 8 + ``payload``), the first is number 1."""
    count = len(data) // payload
    packets = np.empty((count, _HEADER.size + payload), np.uint8)
    packets[:, :_HEADER.size] = np.frombuffer(header(block, PAYLOAD, 0), np.uint8)
    numbers = np.arange(1, count + 1, dtype=">u4").view(np.uint8).reshape(count, 4)
    packets[:, _HEADER.size - 3:_HEADER.size] = numbers[:, 1:]
    packets[:, _HEADER.size:] = np.frombuffer(data, np.uint8, count * payload).reshape(
        count, payload)
    return packets
