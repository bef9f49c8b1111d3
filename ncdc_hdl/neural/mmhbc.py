"""The ``mmhbc`` tan-sigmoid: exponential by predicted hyperbolic rotations, division by LVC."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.fixed import add_signed
from ncdc_hdl.lib.pipeline import delay
from ncdc_hdl.neural.lookup import Lookup
from ncdc_hdl.neural.lvc import Quotient

__all__ = ["Mmhbc"]


class Mmhbc(wiring.Component):
    """Tan-sigmoid of a magnitude a, by the structure of Fig. 9, one addition per stage::

        e = exp(-a)               region table, then u <- u -/+ (u >> s) per fine bit (MMHBC)
        o = (1 - e) / (1 + e)     quotient digits by the remainder's sign (LVC)

    Equal bit for bit to ``TansigDesign.magnitude``, but for its constant last bit. No multiplier.
    Timing: free-running, one value per clock, ``latency`` clocks.

    Parameters
    ----------
    design : ncdc_spec.tansig.TansigDesign

    Members
    -------
    i : ``In(design.input.width - 1)``
    o : ``Out(design.fraction_bits)``
    """

    def __init__(self, design):
        self.design = design
        self.table = Lookup(design.table, design.width)
        self.quotient = Quotient(design.width, design.digits)
        super().__init__({"i": In(design.input.width - 1), "o": Out(design.fraction_bits)})

    @property
    def latency(self):
        """Clocks: table, rotations, quotient."""
        return self.table.latency + len(self.design.shifts) + self.quotient.latency

    def elaborate(self, platform):
        m = Module()
        design = self.design
        width, fine = design.width, design.fine_bits

        # T: region table. In logic: it would take one and a quarter RAMs of 512 x 20 bits.
        m.submodules.table = table = self.table
        m.d.comb += table.i.eq(self.i[fine:])
        u = table.o
        rest = delay(m, self.i[:fine], table.latency, "t_rest")

        # R: one rotation per fine bit, the highest first; 1.0 itself may appear, hence a bit more.
        for k, shift in enumerate(design.shifts):
            r_u = Signal(width + 1, name=f"r{k}_u", reset_less=True)
            m.d.sync += r_u.eq(add_signed(Cat(u, 0), u[shift:], rest[-1], u[shift - 1]))
            u = r_u
            rest = delay(m, rest[:-1], 1, f"r{k}_rest")

        m.submodules.quotient = self.quotient
        m.d.comb += [self.quotient.i.eq(u), self.o.eq(self.quotient.o)]
        return m
