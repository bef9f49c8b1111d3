"""Pipelined signed product, split if multiplier blocks are narrower."""

from functools import partial

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib import pipeline

__all__ = ["Product"]

_LOW = 17       # unsigned bits in a signed input of an 18-bit block


class Product(wiring.Component):
    """``o = a b``, exact, for blocks of 27 x 27 or of 18 x 18 bits.

    Each multiplication has one register before and two after it, which the multiplier blocks of
    common FPGAs absorb. For blocks of 18 bits, a factor wider than that is cut
    into a signed high and an unsigned low part of 17 bits::

        a b = ah bh 2**34 + (ah bl + al bh) 2**17 + al bl

    The first and the last product do not overlap. They are concatenated in one word, and two
    adders in two stages make the sum, a register after those of the blocks. Timing: free-running,
    one product per clock, ``latency`` clocks.

    Parameters
    ----------
    a_width, b_width : int
        Bits of the signed factors.
    multiplier_bits : int
        27: the product is one multiplication; 18: factors of up to 35 bits in two parts.

    Members
    -------
    a, b : ``In(signed(a_width))``, ``In(signed(b_width))``
    o : ``Out(signed(a_width + b_width))``

    Raises
    ------
    ValueError
        If a factor is too wide for two parts.
    """

    def __init__(self, a_width, b_width, multiplier_bits=27):
        widest = max(a_width, b_width)
        if multiplier_bits == 18 and widest > 18 + _LOW:
            raise ValueError(f"a factor has {widest} bits, the limit for two parts is {18 + _LOW}")
        self.multiplier_bits = multiplier_bits
        super().__init__({"a": In(signed(a_width)), "b": In(signed(b_width)),
                          "o": Out(signed(a_width + b_width))})

    @property
    def latency(self):
        """Clocks from the factors to ``o``: 1 in, 2 products; with parts 1 more, 1 for each sum."""
        cut = sum(len(_parts(factor, self.multiplier_bits)) - 1 for factor in (self.a, self.b))
        return 1 + 2 + (1 + cut if cut else 0)

    def elaborate(self, platform):
        m = Module()

        register = partial(pipeline.register, m)

        # Cycle 1: the factors, in parts.
        a = _parts(register("a0", self.a), self.multiplier_bits)
        b = _parts(register("b0", self.b), self.multiplier_bits)
        # Cycles 2 and 3: multiply. The products are keyed by the weight of the parts, 0 or 1 each.
        p = {(j, k): register(f"p1_{j}{k}", register(f"p0_{j}{k}", x * y))
             for j, x in enumerate(a) for k, y in enumerate(b)}
        # Cycle 4, with parts: routing from the blocks to the adders.
        if len(p) > 1:
            p = {weight: register("p2_{}{}".format(*weight), part) for weight, part in p.items()}
        # Cycle 5, if both factors are cut: add the two products in the middle.
        if len(a) == len(b) == 2:
            cross = register("s0_cross", p[0, 1] + p[1, 0])
            outer = register("s0_outer", Cat(p[0, 0], p[1, 1]).as_signed())
        elif len(p) == 2:
            cross, outer = p.get((0, 1), p.get((1, 0))), p[0, 0]
        else:
            m.d.comb += self.o.eq(p[0, 0])
            return m
        # The last cycle: add the middle to the outer ones; the low bits are those of al bl.
        high = register("s1_high", (outer >> _LOW) + cross, signed(len(self.o) - _LOW))
        low = register("s1_low", outer[:_LOW])
        m.d.comb += self.o.eq(Cat(low, high))
        return m


def _parts(factor, multiplier_bits):
    """The parts of a signed ``factor``, low one first; one part if the block holds it."""
    if multiplier_bits != 18 or len(factor) <= 18:
        return [factor]
    return [factor[:_LOW], factor[_LOW:].as_signed()]
