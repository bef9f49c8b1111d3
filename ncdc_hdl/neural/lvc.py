"""Linear vectoring CORDIC (LVC): the quotient (1 - u) / (1 + u), one digit per clock."""

from functools import partial

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.fixed import add_signed

__all__ = ["Quotient"]


class Quotient(wiring.Component):
    """(1 - u) / (1 + u) in digits +-2**-i by the remainder's sign, the first digit positive.

    Equal bit for bit to ``ncdc_spec.tansig.lvc.quotient``, whose last bit is a constant one: ``o``
    leaves it out. Timing: free-running, one value per clock, ``latency`` clocks.

    Parameters
    ----------
    width : int
        Fraction bits of u and of the remainder.
    digits : int
        Quotient digits.

    Members
    -------
    i : ``In(width + 1)``
        u, raw with ``width`` fraction bits; at most a few units above 1.0.
    o : ``Out(digits - 1)``
        The quotient's bits above the last.
    """

    def __init__(self, width, digits):
        self.width, self.digits = width, digits
        super().__init__({"i": In(width + 1), "o": Out(digits - 1)})

    @property
    def latency(self):
        """Clocks: 1 -/+ u, digits but the last, which needs no remainder, the last's register."""
        return 1 + self.digits - 1

    def elaborate(self, platform):
        m = Module()
        width = self.width

        register = partial(pipeline.register, m)

        # N: numerator 1 - u by an addition, denominator 1 + u by wiring.
        remainder = register("n_remainder", (1 << width) - self.i, signed(width + 2))
        divisor = register("n_divisor", Cat(self.i[:width], ~self.i[width], self.i[width]))

        # L: after digit i the remainder is at most divisor >> i, up to the rounding errors, so
        # that the adders shrink. The first digit is always positive, the last needs no remainder.
        digits = Signal(0)
        for i in range(1, self.digits):
            negative = Const(0, 1) if i == 1 else remainder[-1]
            bound = (1 << (width + 1 - i)) + i
            if i > 1:
                digits = register(f"l{i}_digits", Cat(~negative, digits))
            remainder = register(
                f"l{i}_remainder", add_signed(remainder, divisor[i:], ~negative, divisor[i - 1]),
                signed(bound.bit_length() + 1))
            divisor = register(f"l{i}_divisor", divisor)
        m.d.comb += self.o.eq(Cat(~remainder[-1], digits))
        return m
