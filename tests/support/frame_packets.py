"""Packets that a packetiser must make of a frame in memory, written apart from it."""

from ncdc_spec.protocols.link_headers import Headers
from ncdc_spec.registers.link_map import NUMBER_BITS

__all__ = ["packet_of", "packets_of", "some_headers"]


def packet_of(content, headers, base, position):
    """Packet number ``position`` of the frame at ``base`` of the memory's ``content``.

    Number 0 is the leader's. Bytes; empty if there is no such packet.
    """
    payload, kind = b"", "leader"
    if position > headers.packets:
        kind = "trailer"
    elif position:
        kind = "payload" if position < headers.packets else "last"
        at = base + (position - 1) * headers.payload_bytes
        length = headers.payload_bytes if position < headers.packets else headers.last_bytes
        payload = content[at:at + length]
    header = bytearray(getattr(headers, kind))
    at, count = headers.field
    number = (headers.first - 1 + position) % (1 << NUMBER_BITS)
    field = number.to_bytes(4, "big")[4 - count:] if count else b""
    stop = min(at + count, len(header))
    header[at:stop] = field[:max(0, stop - at)]
    return bytes(header) + payload


def packets_of(content, headers, base):
    """All packets of a frame, in order."""
    return [packet for position in range(headers.packets + 2)
            if (packet := packet_of(content, headers, base, position))]


def some_headers(rng, largest, longest=90):
    """Headers of any length below ``longest`` bytes, a field anywhere in or after them.

    ``largest``: bytes of a payload.
    """
    def header(minimum):
        return rng.randbytes(rng.choice((0, minimum, rng.randrange(minimum, longest))))
    payload = 16 * rng.randrange(1, largest // 16 + 1)
    return Headers(header(1), header(0), header(0), header(1),
                   (rng.randrange(0, longest), rng.randrange(0, 5)),
                   rng.choice((0, 1, 5, 0x123456)), payload, rng.randrange(1, 6),
                   rng.randrange(1, payload + 1))
