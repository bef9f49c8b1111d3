"""One of several values by its number."""

from amaranth import *

__all__ = ["chosen"]


def chosen(values, index):
    """The one of ``values``, a power of two of them, that ``index`` counts to, its lowest bit
    first; as a tree, of which synthesis makes half the LUTs that it makes of an ``Array``."""
    values = list(values)
    for bit in index:
        values = [Mux(bit, odd, even) for even, odd in zip(values[::2], values[1::2])]
    return values[0]
