"""One of several values by its number."""

from amaranth import *

__all__ = ["chosen"]


def chosen(values, index):
    """The one of ``values``, a power of two of them, at ``index``, its lowest bit
    first. It is a tree, which takes half the LUTs of an ``Array`` in synthesis."""
    values = list(values)
    for bit in index:
        values = [Mux(bit, odd, even) for even, odd in zip(values[::2], values[1::2])]
    return values[0]
