"""Reciprocal of a view's depth, by a table and two products."""

from functools import partial

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay
from ncdc_hdl.neural.product import Product
from ncdc_spec.reciprocal import (
    CURVE_BITS,
    INDEX_BITS,
    RECIPROCAL_BITS,
    REST_BITS,
    SLOPE_BITS,
    SQUARE_BITS,
    coefficients,
)
from ncdc_spec.view import DEPTH_SHIFTS, FORMATS, SUM_BITS

__all__ = ["Reciprocal"]

_TABLE = 2              # clocks from an index to the memory's output register


class Reciprocal(wiring.Component):
    """1 / m and n of a depth m / 2**n, 1 <= m < 2, and whether it is in its range.

    Equal bit for bit to ``ncdc_model.golden.view.reciprocal`` inside the range.

    Timing: ``shifts`` and ``inside`` are those of the last depth from the clock after ``valid`` on,
    ``o`` from ``latency`` clocks after it on; free-running.

    Parameters
    ----------
    multiplier_bits : int
        Width of the multiplier blocks, 27 or 18.

    Members
    -------
    valid, z : ``In(1)``, ``In(signed(SUM_BITS))``
    shifts, inside : ``Out(range(DEPTH_SHIFTS + 1))``, ``Out(1)``
    o : ``Out(RECIPROCAL_BITS + 1)``
    """

    def __init__(self, multiplier_bits=27):
        self.curve = Product(CURVE_BITS + 1, SQUARE_BITS + 1, multiplier_bits)
        self.slope = Product(SLOPE_BITS + 1, REST_BITS + 1, multiplier_bits)
        super().__init__({
            "valid": In(1), "z": In(signed(SUM_BITS)),
            "shifts": Out(range(DEPTH_SHIFTS + 1)), "inside": Out(1),
            "o": Out(RECIPROCAL_BITS + 1)})

    @property
    def latency(self):
        """Clocks: depth, fraction, table, product, slope, product, value."""
        return 1 + 1 + _TABLE + self.curve.latency + 1 + self.slope.latency + 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.curve, m.submodules.slope = curve, slope = self.curve, self.slope
        register = partial(pipeline.register, m)
        top = FORMATS[2][0].f_bits                  # bit of a depth of 1
        # Depth: its leading one.
        leading = self.z[top - DEPTH_SHIFTS:top + 1]
        z = register("depth", self.z[:top])
        with m.If(self.valid):
            m.d.sync += self.inside.eq(leading.any() & ~self.z[top + 1:].any())
            for shifts in range(DEPTH_SHIFTS, -1, -1):
                with m.If(leading[DEPTH_SHIFTS - shifts]):
                    m.d.sync += self.shifts.eq(shifts)
        # Fraction after the leading one.
        fraction = register("fraction", (z << self.shifts)[top - INDEX_BITS - REST_BITS:top])
        # Table.
        widths = RECIPROCAL_BITS + 1, SLOPE_BITS + 1, CURVE_BITS + 1
        words = [c0 | c1 << widths[0] | c2 << widths[0] + widths[1]
                 for c0, c1, c2 in coefficients()]
        m.submodules.table = table = block_memory(sum(widths), len(words), words)
        read = table.read_port()
        m.d.comb += read.addr.eq(fraction[REST_BITS:])
        word = register("coefficients", read.data)
        c0, c1, c2 = word[:widths[0]], word[widths[0]:-widths[2]], word[-widths[2]:]
        t = delay(m, fraction[:REST_BITS], _TABLE, "t")
        # Slope: the products' factors are not negative.
        m.d.comb += [curve.a.eq(c2), curve.b.eq(t[REST_BITS - SQUARE_BITS:])]
        c1 = delay(m, c1, curve.latency, "c1")
        fine = CURVE_BITS + INDEX_BITS + SQUARE_BITS
        m.d.comb += [
            slope.a.eq(register("slope_at", (c1 - (curve.o >> fine - SLOPE_BITS))[:len(c1)])),
            slope.b.eq(delay(m, t, curve.latency + 1, "late_t")),
        ]
        # Value.
        c0 = delay(m, c0, curve.latency + 1 + slope.latency, "c0")
        shift = SLOPE_BITS + INDEX_BITS + REST_BITS - RECIPROCAL_BITS
        arrived = delay(m, self.valid, self.latency - 1, "valid", reset_less=False)
        with m.If(arrived):
            m.d.sync += self.o.eq(c0 - ((slope.o + (1 << shift - 1)) >> shift))
        return m
