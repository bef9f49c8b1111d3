"""The ``classic`` tan-sigmoid, for comparison: hyperbolic CORDIC in three channels, then LVC."""

from functools import partial

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.fixed import add_signed
from ncdc_hdl.lib.pipeline import delay
from ncdc_hdl.neural.lvc import Quotient
from ncdc_hdl.neural.product import Product

__all__ = ["Classic"]


class Classic(wiring.Component):
    """Tan-sigmoid of a magnitude a, after Asari's neuron, [15] of the paper::

        x + y = exp(-fraction)                hyperbolic CORDIC (24)-(28), 4 and 13 repeated
        e = exp(-integer) (x + y)             small table, one product (29)
        o = (1 - e) / (1 + e)                 quotient digits by the remainder's sign (LVC)

    Equal bit for bit to ``ClassicDesign.magnitude``, but for its constant last bit. Timing:
    free-running, one value per clock, ``latency`` clocks.

    Parameters
    ----------
    design : ncdc_spec.tansig.ClassicDesign

    Members
    -------
    i : ``In(design.input.width - 1)``
    o : ``Out(design.fraction_bits)``
    """

    def __init__(self, design):
        self.design = design
        # Signed factors for blocks of 18 bits, which all FPGAs support.
        self.product = Product(design.width + 2, design.width + 2, 18)
        self.quotient = Quotient(design.width, design.digits)
        super().__init__({"i": In(design.input.width - 1), "o": Out(design.fraction_bits)})

    @property
    def latency(self):
        """Clocks: iterations, x + y, product, rounding, quotient."""
        return len(self.design.shifts) + 1 + self.product.latency + 1 + self.quotient.latency

    def elaborate(self, platform):
        m = Module()
        design = self.design
        width, fraction = design.width, design.input.f_bits

        register = partial(pipeline.register, m)

        # C: one iteration per stage. The first direction is known, and so are its x and y.
        channel = signed(width + 2)
        x, y = Const(design.start, channel), Const(0, channel)
        z = -(self.i[:fraction] << (width - fraction))
        for k, (shift, angle) in enumerate(zip(design.shifts, design.angles)):
            minus = Const(1, 1) if k == 0 else z[-1]
            dx, dy = y[shift:].as_signed(), x[shift:].as_signed()
            x, y, z = (register(f"c{k}_x", add_signed(x, dx, minus, y[shift - 1]), channel),
                       register(f"c{k}_y", add_signed(y, dy, minus, x[shift - 1]), channel),
                       register(f"c{k}_z", z + Mux(minus, angle, -angle), channel))
        u = register("u", (x + y)[:width + 1])

        # P: product with the integer part's exponential, rounded.
        m.submodules.table = table = Memory(shape=width + 1, depth=len(design.table),
                                            init=design.table)
        read = table.read_port()
        m.d.comb += read.addr.eq(delay(m, self.i[fraction:], len(design.shifts), "integer"))
        m.submodules.product = product = self.product
        m.d.comb += [product.a.eq(u), product.b.eq(read.data)]
        e = register("p_e", (product.o[width:2 * width + 1] + product.o[width - 1])[:width + 1])

        m.submodules.quotient = self.quotient
        m.d.comb += [self.quotient.i.eq(e), self.o.eq(self.quotient.o)]
        return m
