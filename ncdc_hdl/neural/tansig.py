"""Tan-sigmoid of a hidden neuron: sign and magnitude around one of the variants."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import delay
from ncdc_hdl.neural.classic import Classic
from ncdc_hdl.neural.mmhbc import Mmhbc
from ncdc_hdl.neural.table import Table

__all__ = ["Tansig"]

_VARIANTS = {"mmhbc": Mmhbc, "classic": Classic, "table": Table}


class Tansig(wiring.Component):
    """Tan-sigmoid of a hidden neuron, equation (17) with gamma = 1: o = sign(n) f(\\|n\\|).

    Equal bit for bit to ``ncdc_spec.tansig.tansig``: odd, o(0) = 0, last bit constant.
    Timing: free-running, one value per clock, no stall; ``latency`` clocks from ``i`` to ``o``.

    Parameters
    ----------
    design : ncdc_spec.tansig.Design
        Variant, formats, widths, tables.

    Members
    -------
    i : ``In(signed(design.input.width))``
        n.
    o : ``Out(signed(design.output.width))``
        f(n).
    """

    def __init__(self, design):
        self.design = design
        self.variant = _VARIANTS[design.variant](design)
        super().__init__({"i": In(signed(design.input.width)),
                          "o": Out(signed(design.output.width))})

    @property
    def latency(self):
        """Clocks: magnitude, the variant's, sign."""
        return 1 + self.variant.latency + 1

    def elaborate(self, platform):
        m = Module()
        design = self.design
        m.submodules.variant = variant = self.variant

        # A: sign and magnitude. The most negative n has none: its sign with a zero represents it.
        bits = design.input.width - 1
        magnitude = Signal(bits, name="a_magnitude", reset_less=True)
        sign = Signal(name="a_sign", reset_less=True)
        negative = self.i[-1]
        m.d.sync += [magnitude.eq((self.i[:bits] ^ negative.replicate(bits)) + negative),
                     sign.eq(negative)]
        m.d.comb += variant.i.eq(magnitude)
        negative, zero = delay(m, Cat(sign, magnitude == 0), variant.latency, "sign_zero")

        # S: -q is ~q below the constant last bit, so restoring the sign needs no carry.
        q = Cat(variant.o, 0)
        o = Signal.like(self.o, name="s_o", reset_less=True)
        m.d.sync += o.eq(Mux(zero, Mux(negative, -design.largest, 0),
                             Cat(1, q ^ negative.replicate(len(q)))))
        m.d.comb += self.o.eq(o)
        return m
