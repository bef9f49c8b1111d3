"""The order of the corrected pixels: raster, or strips of columns."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.lib.pipeline import delay
from ncdc_model.geometry import MAX_SIZE, STRIP_UNIT

__all__ = ["ORDER", "Strips"]

ORDER = data.StructLayout({"width": SIZE, "height": SIZE, "strip": SIZE})


class Strips(wiring.Component):
    """Counts through a picture: strips left to right, rows top down, columns left to right.

    A strip has ``order.strip`` columns, the last one what is left. A width of 0 makes the whole
    picture one strip: a raster. Equal to ``ncdc_model.geometry.scan_order``.

    Groups and rows are counted down to -1, so that the sign tells the last one without a
    comparison. Timing: another group shows in the clock after ``advance``; the first one is to be
    asked for with ``begin``, and shows ``latency`` clocks after ``start``. The width of a picture
    is not to be 0.

    Parameters
    ----------
    lanes : int
        Pixels of a group, counted together; a power of two, at most ``STRIP_UNIT / 8``. The width
        of the picture is to be a multiple of it.

    Members
    -------
    order : ``In(ORDER)``
        Sizes in pixels, constant from ``start`` on. Bits below ``STRIP_UNIT`` of the strip's width
        are ignored.
    start, advance : ``In(1)``
    soon, begin : ``Out(1)``
        The clock before ``begin``; the clock in which to ``advance`` for the first group.
    u : ``Out``
        Column of the group's leftmost pixel.
    last_column, last_row, last_strip : ``Out(1)``
        Whether the group is the last of its row within the strip; its row the last of the
        picture; its strip the last.
    strip, raster : ``Out``
        Columns of a strip but the last; the whole picture is one.
    """

    latency = 6

    def __init__(self, lanes=1):
        self.lanes = lanes
        super().__init__({
            "order": In(ORDER), "start": In(1), "advance": In(1), "soon": Out(1), "begin": Out(1),
            "u": Out(SIZE),
            "last_column": Out(1), "last_row": Out(1), "last_strip": Out(1),
            "strip": Out(SIZE), "raster": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        order, unit, group = self.order, exact_log2(STRIP_UNIT), exact_log2(self.lanes)
        count = range(-MAX_SIZE - 1, MAX_SIZE)
        left = Signal(SIZE)                          # first column of the strip
        next_strip = Signal()
        column, row = Signal(count), Signal(count)   # to be counted down to -1: the last one
        groups, rows = Signal(count), Signal(count)  # of this strip's row, of the picture; less two
        m.d.comb += [
            self.strip.eq(Cat(Const(0, unit), order.strip[unit:])),
            self.raster.eq(self.strip == 0),
            self.last_column.eq(column < 0), self.last_row.eq(row < 0),
            next_strip.eq(self.advance & self.last_column & self.last_row),
        ]
        m.d.comb += self.soon.eq(delay(m, self.start, self.latency - 2, "start", reset_less=False))
        m.d.sync += self.begin.eq(self.soon)
        # The strip to come, worked out in three clocks from the columns right of its first one;
        # in a fourth what the row to come has: no strip but the last has a row of so few groups.
        columns, beyond = Signal(count), Signal(count)
        less_one, last, less_two = Signal(count), Signal(1), Signal(count)
        row_groups = Signal(count)
        m.d.sync += [
            beyond.eq(columns - self.strip),
            last.eq(self.raster | (beyond < 0)),
            less_one.eq(Mux(self.raster | (beyond < 0), columns, self.strip - 1) >> group),
            less_two.eq(less_one - 1), rows.eq(order.height - 2),
            row_groups.eq(Mux(self.last_row, less_two, groups)),
        ]
        further = Signal(SIZE)
        m.d.comb += further.eq(self.u + self.lanes)
        with m.If(self.advance):
            m.d.sync += [
                column.eq(Mux(self.last_column, row_groups, column - 1)),
                self.u.eq(Mux(self.last_column & ~self.last_row, left, further)),
            ]
        with m.If(self.advance & self.last_column):
            m.d.sync += row.eq(Mux(self.last_row, rows, row - 1))
        with m.If(next_strip):
            m.d.sync += [left.eq(further), groups.eq(less_two), columns.eq(beyond),
                         self.last_strip.eq(last)]
        with m.If(self.start):
            # As at the end of a strip on the left of the picture.
            m.d.sync += [column.eq(-1), row.eq(-1), self.u.eq(-self.lanes),
                         columns.eq(order.width - 1)]
        return m
