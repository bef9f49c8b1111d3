"""Layouts between the parts of the packetiser."""

from amaranth.lib import data, enum

from ncdc_spec.registers.link_map import NUMBER_BITS, PAYLOAD_BITS

__all__ = ["BEAT", "ENTRY", "JOB", "Template"]


class Template(enum.Enum, shape=2):
    """The headers, in the order in memory."""
    LEADER = 0
    PAYLOAD = 1
    LAST = 2
    TRAILER = 3


JOB = data.StructLayout({
    "template": Template, "bank": 1,    # set of headers
    "number": NUMBER_BITS,              # number of the packet
    "last": PAYLOAD_BITS,               # bytes of its payload, less one: valid a little later
    "again": 1,                         # it was sent before
})
"""A packet to be made."""

BEAT = data.StructLayout({"data": 32, "empty": 2, "last": 1})
"""Four bytes of an Ethernet frame, the first in the lowest; the last beat lacks the ``empty``
highest ones."""

ENTRY = data.StructLayout({"beat": BEAT, "again": 1})
"""A beat of a packet, and whether the packet was sent before."""
