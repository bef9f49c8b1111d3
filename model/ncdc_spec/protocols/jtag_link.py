"""Registers through a JTAG scan of 64 bits: what host and board send each other.

From the top: kind (8 bits), tag (8), word address (16), word (32). The host scans a request in;
a later scan brings its answer: the same with the word that was read, or that was written. Before
there is an answer, and after it, the kind is 0. The tag is the host's. It distinguishes an answer
from that to an earlier host.
"""

__all__ = ["BITS", "NOTHING", "READ", "WRITE", "jtag_message"]

BITS = 64
NOTHING, READ, WRITE = range(3)
"""Kinds."""


def jtag_message(kind, tag, address, word=0):
    """A request, or its answer, as a number that is scanned lowest bit first."""
    return kind << 56 | tag << 48 | address << 32 | word
