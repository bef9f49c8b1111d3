"""The ``table`` tan-sigmoid: a quadratic per segment of the magnitude."""

from functools import partial

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib import pipeline
from ncdc_hdl.lib.pipeline import delay
from ncdc_hdl.neural.lookup import Lookup

__all__ = ["Table"]

_LOW = 18       # most bits of a factor's low part: an unsigned input of an 18-bit block
_PRODUCT = 4    # clocks: 1 before a multiplication and 2 after, which blocks absorb; 1 for routing


class Table(wiring.Component):
    """Tan-sigmoid of a magnitude: value + t (slope - t curvature), t the position in a segment.

    Equal bit for bit to ``TableDesign.magnitude``, but for its constant last bit: floored to the
    result's bits, at most all ones. In each of the two products one factor is cut into its low 18
    bits and the others, so that each part fits a multiplier block of 18 x 18 bits. Two of these
    fit one of 27 x 27. A part of two bits takes an adder instead of a block. Timing: free-running,
    one value per clock, ``latency`` clocks.

    Parameters
    ----------
    design : ncdc_spec.tansig.TableDesign

    Members
    -------
    i : ``In(design.input.width - 1)``
    o : ``Out(design.fraction_bits)``
    """

    def __init__(self, design):
        self.design = design
        value, slope, curvature = zip(*design.coefficients)
        widths = design.coefficient_bits
        self.value, self.slope, self.curvature = (
            Lookup(column, width) for column, width in zip((value, slope, curvature), widths))
        super().__init__({"i": In(design.input.width - 1), "o": Out(design.fraction_bits)})

    @property
    def latency(self):
        """Clocks: segment, table, product, its parts, slope, product, its parts 2, limit."""
        return 1 + self.curvature.latency + _PRODUCT + 1 + 1 + _PRODUCT + 2 + 1

    def elaborate(self, platform):
        m = Module()
        design = self.design
        bits = design.position_bits
        for name in ("value", "slope", "curvature"):
            m.submodules[name] = getattr(self, name)

        register = partial(pipeline.register, m)

        # A: segment and position in it; the two top bits select the range. The number of a range's
        # first segment is a multiple of their number in it.
        segment = Signal(range(design.entries), name="a_segment", reset_less=True)
        position = Signal(bits, name="a_position", reset_less=True)
        top = len(self.i) - 2
        for number, (entry, _, log) in enumerate(design.ranges):
            end = top + 1 if number == 2 else top
            with [m.If(self.i[top:] == 0), m.Elif(~self.i[-1]), m.Else()][number]:
                m.d.sync += [segment.eq(entry | self.i[log:end]),
                             position.eq(self.i[:log] << (bits - log))]

        # T: each coefficient is looked up when it is needed.
        table = self.curvature.latency
        summed = _PRODUCT + 1
        m.d.comb += [
            self.curvature.i.eq(segment),
            self.slope.i.eq(delay(m, segment, summed, "t_slope")),
            self.value.i.eq(delay(m, self.slope.i, 1 + _PRODUCT, "t_value")),
        ]
        position = delay(m, position, table, "t_position")

        # S: the slope at the position. Below the cut nothing is added to a product's low part.
        cut = min(_LOW, bits)
        low, high = self._product(m, "s", self.curvature.o, position, cut)
        product = register("s_product", (low >> cut) + high)
        slope = register("s_slope", self.slope.o - (product >> (bits - cut)), len(self.slope.o))

        # V: the value, floored; values above the largest result become the largest result.
        below = design.slope_bits + bits
        cut = min(_LOW, below - design.offset_bits)
        low, high = self._product(m, "v", slope, delay(m, position, summed + 1, "v_position"), cut)
        value = register("v_high", (self.value.o << (below - design.offset_bits - cut)) + high)
        total = register("v_total", value + register("v_low", low >> cut))
        result = total[below - cut - design.fraction_bits:]
        over = result[design.fraction_bits:].any()
        m.d.comb += self.o.eq(register(
            "v_o", result[:design.fraction_bits] | over.replicate(design.fraction_bits)))
        return m

    @staticmethod
    def _product(m, name, factor, position, cut):
        """The low ``cut`` bits of ``factor``, and the others, times ``position``."""
        position = delay(m, position, 1, f"{name}_position")

        def times(part):
            if len(part) > 2:
                return part * position
            return sum((Mux(bit, position << k, 0) for k, bit in enumerate(part)), Const(0, 1))
        return [delay(m, times(delay(m, part, 1, f"{name}{k}_factor")), _PRODUCT - 1,
                      f"{name}{k}_product")
                for k, part in enumerate((factor[:cut], factor[cut:]))]
