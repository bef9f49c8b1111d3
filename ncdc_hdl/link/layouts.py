"""What the parts of the packetiser hand each other."""

from amaranth.lib import data, enum

from ncdc_hdl.avalon.bus import ADDRESS_BITS
from ncdc_model.interface.link_map import NUMBER_BITS, PAYLOAD_BITS

__all__ = ["BEAT", "JOB", "PIECE", "PLAN", "Template"]


class Template(enum.Enum, shape=2):
    """The headers, in the order in which they lie in memory."""
    LEADER = 0
    PAYLOAD = 1
    LAST = 2
    TRAILER = 3


PLAN = data.StructLayout({"payload": PAYLOAD_BITS, "packets": NUMBER_BITS, "last": PAYLOAD_BITS,
                          "first": NUMBER_BITS})
"""How a frame is cut: bytes of a packet, packets, bytes of the last one, number of the first."""

JOB = data.StructLayout({
    "template": Template, "bank": 1,    # the header
    "number": NUMBER_BITS,              # of the packet
    "address": ADDRESS_BITS,            # of its payload, in bytes
    "bytes": PAYLOAD_BITS,              # of the payload; 0 of leader and trailer
    "again": 1,                         # it was sent before
})
"""A packet to be sent."""

PIECE = data.StructLayout({"data": 32, "bytes": range(5), "last": 1})
"""Bytes of a packet, the first in the lowest: four but before the payload and at the end."""

BEAT = data.StructLayout({"data": 32, "empty": 2, "last": 1})
"""Four bytes of an Ethernet frame, the first in the lowest; the last beat lacks the ``empty``
highest ones."""
