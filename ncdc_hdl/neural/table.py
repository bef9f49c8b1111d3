"""The ``table`` tan-sigmoid: a quadratic per segment of the magnitude."""

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from ncdc_hdl import pipeline
from ncdc_hdl.pipeline import delay

__all__ = ["Table"]


class Table(wiring.Component):
    """Tan-sigmoid of a magnitude: value + t (slope - t curvature), t the position in a segment.

    Equal bit for bit to ``TableDesign.magnitude``, but for its constant last bit: floored to the
    result's bits, at most all ones. Two products, with two registers before and one after each,
    which multiplier blocks take into themselves. Timing: free-running, one value per clock,
    ``latency`` clocks.

    Parameters
    ----------
    design : ncdc_model.tansig.TableDesign

    Members
    -------
    i : ``In(design.input.width - 1)``
    o : ``Out(design.fraction_bits)``
    """

    def __init__(self, design):
        self.design = design
        super().__init__({"i": In(design.input.width - 1), "o": Out(design.fraction_bits)})

    @property
    def latency(self):
        """Clocks: segment, table and its register, product, slope, its register, product, value."""
        return 1 + 2 + 1 + 1 + 1 + 1 + 1

    def elaborate(self, platform):
        m = Module()
        design = self.design
        bits = design.position_bits

        register = partial(pipeline.register, m)

        # A: segment and position in it; the two top bits tell the range.
        segment = Signal(range(design.entries), name="a_segment", reset_less=True)
        position = Signal(bits, name="a_position", reset_less=True)
        for number, (entry, first, log) in enumerate(design.ranges):
            with [m.If(self.i[-2:] == 0), m.Elif(~self.i[-1]), m.Else()][number]:
                m.d.sync += [segment.eq(entry + ((self.i - first)[log:])),
                             position.eq(self.i[:log] << (bits - log))]

        # T: coefficients, with a second register that block RAMs can absorb.
        widths = design.coefficient_bits
        layout = data.StructLayout(dict(zip(("value", "slope", "curvature"), widths)))
        rows = [dict(zip(layout.members, row)) for row in design.coefficients]
        m.submodules.table = table = Memory(shape=layout, depth=len(rows), init=rows)
        read = table.read_port()
        m.d.comb += read.addr.eq(segment)
        row = Signal(layout, name="t_row", reset_less=True)
        m.d.sync += row.eq(read.data)
        position = delay(m, position, 2, "t_position")

        # S: the slope at the position.
        product = register("s_product", row.curvature * position)
        slope = register("s_slope", delay(m, row.slope, 1, "s_first") - product[bits:], widths[1])
        slope = register("s_factor", slope)

        # V: the value, floored; what the approximation puts above the last result is that.
        product = register("v_product", slope * delay(m, position, 3, "v_position"))
        value = delay(m, row.value, 4, "v_value")
        below = design.slope_bits + bits
        result = (value << (below - design.offset_bits)) + product
        total = Signal(result.shape(), name="v_total")
        m.d.comb += total.eq(result)
        top = total[below - design.fraction_bits:]
        over = top[design.fraction_bits:].any()
        m.d.comb += self.o.eq(register(
            "v_o", top[:design.fraction_bits] | over.replicate(design.fraction_bits)))
        return m
