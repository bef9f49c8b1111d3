"""Bilinear interpolation between the colours of four quads."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.bayer import QUADS
from ncdc_hdl.pipeline import delay

__all__ = ["Bilinear"]


class Bilinear(wiring.Component):
    """Separable linear interpolation, equations (30)-(32) and Fig. 15, one rounding at the end::

        upper = 2**f q00 + fx (q01 - q00)       lower likewise from the second row of quads
        o     = (2**f upper + fy (lower - upper) + half) >> (2 f + 1)

    for each colour; the last bit dropped is the quads' unit of a half. Equal bit for bit to
    ``ncdc_model.picture.bilinear``. Timing: free-running, ``latency`` clocks; two registers
    stand after each product. Nine multipliers.

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

    latency = 9

    def __init__(self, f_bits):
        self.f_bits = f_bits
        super().__init__({"i": In(QUADS), "fx": In(f_bits), "fy": In(f_bits),
                          "o": Out(data.ArrayLayout(8, 3))})

    def elaborate(self, platform):
        m = Module()
        fx = delay(m, self.fx, 1, "fx")
        fy = delay(m, self.fy, 5, "fy")

        def lerp(name, a, b, fraction):
            """a 2**f + fraction (b - a), 4 clocks later; ``fraction`` comes 1 clock after a, b."""
            difference = Signal(signed(len(a) + 1), name=f"{name}_d", reset_less=True)
            m.d.sync += difference.eq(b - a)
            product = Signal(signed(len(difference) + self.f_bits), name=f"{name}_p",
                             reset_less=True)
            m.d.sync += product.eq(difference * fraction)
            total = Signal(len(a) + self.f_bits, name=f"{name}_s", reset_less=True)
            m.d.sync += total.eq((delay(m, a, 3, f"{name}_a") << self.f_bits)
                                 + delay(m, product, 1, f"{name}_p"))
            return total

        for colour in range(3):
            q00, q01, q10, q11 = (self.i[6 * j + 3 * i + colour]
                                  for j in range(2) for i in range(2))
            upper = lerp(f"u{colour}", q00, q01, fx)
            lower = lerp(f"l{colour}", q10, q11, fx)
            shift = 2 * self.f_bits + 1
            total = lerp(f"v{colour}", upper, lower, fy)
            # Adding a half carries exactly if the highest bit dropped is set.
            m.d.sync += self.o[colour].eq(total[shift:] + total[shift - 1])
        return m
