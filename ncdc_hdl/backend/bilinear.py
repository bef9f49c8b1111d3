"""Bilinear interpolation between the colours of four quads."""

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.bayer import QUADS
from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.pipeline import delay

__all__ = ["Bilinear"]

_BLOCK = 18     # bits of a multiplier block


class Bilinear(wiring.Component):
    """Separable linear interpolation, equations (30)-(32) and Fig. 15, one rounding at the end::

        upper = 2**f q00 + fx (q01 - q00)       lower likewise from the second row of quads
        o     = (2**f upper + fy (lower - upper) + half) >> (2 f + 1)

    for each colour; the last bit dropped is the quads' unit of a half. Equal bit for bit to
    ``ncdc_model.picture.bilinear``. Timing: free-running, ``latency`` clocks; a register stands
    before each product, beside that of the difference, and two after it. Nine multipliers of 18
    bits: the second step's differences have two bits more, whose products with fy are of a few
    bits and added one clock later.

    Parameters
    ----------
    f_bits : int
        Fraction bits of fx and fy.

    Members
    -------
    i : ``In(QUADS)``
    fx, fy : ``In(f_bits)``
    o : ``Out(ArrayLayout(8, 3))``
        Red, green, blue.
    """

    latency = 12

    def __init__(self, f_bits):
        self.f_bits = f_bits
        super().__init__({"i": In(QUADS), "fx": In(f_bits), "fy": In(f_bits),
                          "o": Out(data.ArrayLayout(8, 3))})

    def elaborate(self, platform):
        m = Module()
        fx = delay(m, self.fx, 2, "fx")
        fy = delay(m, self.fy, 7, "fy")

        register = partial(pipeline.register, m)

        def lerp(name, a, b, fraction, cut=False):
            """a 2**f + fraction (b - a), 5 clocks later; ``fraction`` comes 2 clocks after a, b.

            ``cut``: 6 clocks later; what of the difference is above the block is multiplied apart.
            """
            # Cycles 1 and 2: subtract, and the register before the multiplier.
            difference = delay(m, register(f"{name}_d", b - a), 1, f"{name}_d")
            place = min(_BLOCK, len(difference)) - 1
            low = difference[:place] if cut else difference
            # Cycles 3 and 4: multiply.
            product = register(f"{name}_p1", register(f"{name}_p0", low * fraction))
            # Cycle 5, if cut: add the product of the bits above the block.
            if cut:
                high = difference[place:].as_signed() * fraction
                above = register(f"{name}_h1", register(f"{name}_h0", high))
                product = register(f"{name}_p2", product + (above << place))
            # The last cycle: add a.
            first = delay(m, a, 5 if cut else 4, f"{name}_a") << self.f_bits
            return register(f"{name}_s", first + product, unsigned(len(a) + self.f_bits))

        for colour in range(3):
            q00, q01, q10, q11 = (self.i[6 * j + 3 * i + colour]
                                  for j in range(2) for i in range(2))
            # Cycles 1 to 5: interpolate along both rows of quads.
            upper = lerp(f"u{colour}", q00, q01, fx)
            lower = lerp(f"l{colour}", q10, q11, fx)
            # Cycles 6 to 11: interpolate between the rows.
            shift = 2 * self.f_bits + 1
            total = lerp(f"v{colour}", upper, lower, fy, cut=True)
            # Cycle 12: round. Adding a half carries exactly if the highest bit dropped is set.
            m.d.sync += self.o[colour].eq(total[shift:] + total[shift - 1])
        return m
