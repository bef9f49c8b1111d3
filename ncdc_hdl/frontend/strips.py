"""The order of the corrected pixels: raster, or strips of columns."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.pipeline import delay
from ncdc_model.geometry import MAX_SIZE, STRIP_UNIT

__all__ = ["ORDER", "Strips"]

ORDER = data.StructLayout({"width": SIZE, "height": SIZE, "strip": SIZE})


class Strips(wiring.Component):
    """Counts through a picture: strips left to right, rows top down, columns left to right.

    A strip has ``order.strip`` columns, the last one what is left. A width of 0 makes the whole
    picture one strip: a raster. Equal to ``ncdc_model.geometry.scan_order``.

    Groups and rows are counted down to -1, so that the sign tells the last one without a
    comparison. Timing: the first group shows ``latency`` clocks after ``start``, the next one in
    the clock after ``advance``. The width of a picture is not to be 0.

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
    begin : ``Out(1)``
        The first group shows in the next clock.
    u : ``Out``
        Column of the group's leftmost pixel.
    last_column, last_row, last_strip : ``Out(1)``
        Whether the group is the last of its row within the strip; its row the last of the
        picture; its strip the last.
    strip, raster : ``Out``
        Columns of a strip but the last; the whole picture is one.
    """

    latency = 5

    def __init__(self, lanes=1):
        self.lanes = lanes
        super().__init__({
            "order": In(ORDER), "start": In(1), "advance": In(1), "begin": Out(1), "u": Out(SIZE),
            "last_column": Out(1), "last_row": Out(1), "last_strip": Out(1),
            "strip": Out(SIZE), "raster": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        order, unit, group = self.order, exact_log2(STRIP_UNIT), exact_log2(self.lanes)
        count = range(-MAX_SIZE - 1, MAX_SIZE)
        left = Signal(SIZE)                          # first column of the strip
        # Groups of this strip's row, and rows of the picture, less two: what to count down from.
        groups, rows = Signal(count), Signal(count)
        column, row = Signal(count), Signal(count)   # -1: the last
        m.d.comb += [
            self.strip.eq(Cat(Const(0, unit), order.strip[unit:])),
            self.raster.eq(self.strip == 0),
            self.begin.eq(delay(m, self.start, self.latency - 1, "start", reset_less=False)),
            self.last_column.eq(column < 0), self.last_row.eq(row < 0),
        ]
        # The strip to come, worked out in three clocks from the columns right of its first one:
        # no strip but the last has a row of so few groups.
        columns, beyond = Signal(count), Signal(count)
        less_one, last, less_two = Signal(count), Signal(1), Signal(count)
        m.d.sync += [
            beyond.eq(columns - self.strip),
            last.eq(self.raster | (beyond < 0)),
            less_one.eq(Mux(self.raster | (beyond < 0), columns, self.strip - 1) >> group),
            less_two.eq(less_one - 1), rows.eq(order.height - 2),
        ]
        u_next = Signal(SIZE)
        m.d.comb += u_next.eq(self.u + self.lanes)
        with m.If(self.advance):
            m.d.sync += [column.eq(column - 1), self.u.eq(u_next)]
            with m.If(self.last_column):
                m.d.sync += [column.eq(groups), row.eq(row - 1)]
                with m.If(~self.last_row):
                    m.d.sync += self.u.eq(left)
        with m.If(self.start):
            m.d.sync += columns.eq(order.width - 1)
        with m.If(self.begin):
            m.d.sync += [self.u.eq(0), left.eq(0)]
        with m.Elif(self.advance & self.last_column & self.last_row):
            m.d.sync += left.eq(u_next)
        with m.If(self.begin | self.advance & self.last_column & self.last_row):
            m.d.sync += [groups.eq(less_two), column.eq(less_two), row.eq(rows),
                         self.last_strip.eq(last), columns.eq(beyond)]
        return m
