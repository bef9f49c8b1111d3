"""Headers for the packetiser: Ethernet, IP, UDP, then GVSP or Table II."""

import struct
from dataclasses import dataclass

from ncdc_spec.errors import InputError
from ncdc_spec.protocols import gvsp

__all__ = ["Endpoint", "Headers", "gvsp_headers", "mraw_headers", "stacked"]

_ETHERNET, _IP, _UDP = 14, 20, 8
_LONGEST = 9000         # bytes of an IP packet in a jumbo frame


@dataclass(frozen=True)
class Endpoint:
    """Who sends, or receives.

    Parameters
    ----------
    mac : bytes of length 6
    ip : bytes of length 4
    port : int
        UDP port.
    """
    mac: bytes
    ip: bytes
    port: int


@dataclass(frozen=True)
class Headers:
    """What the packetiser's registers say of a frame's packets.

    Parameters
    ----------
    leader, payload, last, trailer : bytes
        Headers; an empty one: no such packet.
    field : (int, int)
        Byte of the header at which the packet's number stands, and how many bytes it has.
    first : int
        Number of the first payload packet.
    payload_bytes, packets, last_bytes : int
        Bytes of the frame in a packet, packets, bytes in the last of them.
    """
    leader: bytes
    payload: bytes
    last: bytes
    trailer: bytes
    field: tuple
    first: int
    payload_bytes: int
    packets: int
    last_bytes: int


def stacked(source, target, inner, payload_bytes):
    """Ethernet, IP and UDP headers before the header ``inner``, which ``payload_bytes`` follow.

    The UDP check sum is 0: none, as packets of one header differ in number and payload.

    Raises
    ------
    InputError
        If the packet is longer than a jumbo frame's.
    """
    length = _UDP + len(inner) + payload_bytes
    if _IP + length > _LONGEST:
        raise InputError(f"a packet has {_IP + length} bytes, the limit is {_LONGEST}")
    # Version and length of the header, identification 0, do not fragment, 64 hops, UDP.
    ip = struct.pack(">BBHHHBBH4s4s", 0x45, 0, _IP + length, 0, 0x4000, 64, 17, 0, source.ip,
                     target.ip)
    ip = ip[:10] + struct.pack(">H", _check_sum(ip)) + ip[12:]
    return (target.mac + source.mac + b"\x08\x00" + ip
            + struct.pack(">HHHH", source.port, target.port, length, 0) + inner)


def _check_sum(header):
    """IP's check sum of a header in which it is 0."""
    total = sum(struct.unpack(f">{len(header) // 2}H", header))
    while total >> 16:
        total = (total & 0xFFFF) + (total >> 16)
    return total ^ 0xFFFF


def _cut(size, payload_bytes):
    """(packets, bytes in the last one) of a frame of ``size`` bytes."""
    if payload_bytes < 16 or payload_bytes % 16:
        raise InputError(f"a packet has {payload_bytes} bytes of the frame, it must be a multiple "
                         f"of 16")
    packets = -(-size // payload_bytes)
    return packets, size - (packets - 1) * payload_bytes


def gvsp_headers(source, target, picture, block, time_ns, payload_bytes):
    """:class:`Headers` of a picture over GVSP.

    Parameters
    ----------
    source, target : Endpoint
    picture : (PixelFormat, int, int)
        Format, width and height.
    block : int
        Number of the picture, 1..65535.
    time_ns : int
    payload_bytes : int
        A multiple of 16.
    """
    pixels, width, height = picture
    packets, last = _cut(pixels.pixel_bytes * width * height, payload_bytes)
    part = gvsp.header(block, gvsp.PAYLOAD, 0)
    return Headers(
        stacked(source, target, gvsp.leader(block, time_ns, pixels, (width, height)), 0),
        stacked(source, target, part, payload_bytes), stacked(source, target, part, last),
        stacked(source, target, gvsp.trailer(block, 0, height), 0),
        (_ETHERNET + _IP + _UDP + 5, 3), 1, payload_bytes, packets, last)


def mraw_headers(source, target, package, payload_bytes):
    """:class:`Headers` of a Table II package over UDP: its header is the leader, packet 0, and each
    packet begins with its number in four bytes, the top one 0.

    ``package``: the MrawHeader.
    """
    packets, last = _cut(package.size, payload_bytes)
    number = bytes(4)
    return Headers(
        stacked(source, target, number + package.pack(), 0),
        stacked(source, target, number, payload_bytes), stacked(source, target, number, last),
        b"", (_ETHERNET + _IP + _UDP, 4), 1, payload_bytes, packets, last)
