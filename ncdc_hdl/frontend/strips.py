"""The order of the corrected pixels: raster, or strips of columns."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.layouts import SIZE
from ncdc_model.geometry import STRIP_UNIT

__all__ = ["ORDER", "Strips"]

ORDER = data.StructLayout({"width": SIZE, "height": SIZE, "strip": SIZE})


class Strips(wiring.Component):
    """Counts through a picture: strips left to right, rows top down, columns left to right.

    A strip has ``order.strip`` columns, the last one what is left. A width of 0 makes the whole
    picture one strip: a raster. Equal to ``ncdc_model.geometry.scan_order``.

    Timing: ``start`` shows the first group in the next clock, ``advance`` the next one. The width
    of a picture is not to be 0.

    Parameters
    ----------
    lanes : int
        Pixels of a group, counted together; a power of two, at most ``STRIP_UNIT``. The width of
        the picture is to be a multiple of it.

    Members
    -------
    order : ``In(ORDER)``
        Sizes in pixels, constant from ``start`` on. Bits below ``STRIP_UNIT`` of the strip's width
        are ignored.
    start, advance : ``In(1)``
    u, v : ``Out``
        Column of the group's leftmost pixel, and its row.
    last_column, last_row, last_strip : ``Out(1)``
        Whether the group is the last of its row within the strip; its row the last of the
        picture; its strip the last.
    strip, raster : ``Out``
        Columns of a strip but the last; the whole picture is one.
    """

    def __init__(self, lanes=1):
        self.lanes = lanes
        super().__init__({
            "order": In(ORDER), "start": In(1), "advance": In(1), "u": Out(SIZE), "v": Out(SIZE),
            "last_column": Out(1), "last_row": Out(1), "last_strip": Out(1),
            "strip": Out(SIZE), "raster": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        order, unit = self.order, exact_log2(STRIP_UNIT)
        left = Signal(SIZE)                          # first column of the strip
        edge = Signal(SIZE)                          # last column of the strip
        # The next strip's edge, a clock late: no strip but the last has so few columns.
        next_edge, next_last = Signal(SIZE), Signal()

        def limited(column):
            beyond = self.raster | (column >= order.width - 1)
            return Mux(beyond, order.width - 1, column), beyond

        group = exact_log2(self.lanes)
        m.d.comb += [
            self.strip.eq(Cat(Const(0, unit), order.strip[unit:])),
            self.raster.eq(self.strip == 0),
            self.last_column.eq(self.u[group:] == edge[group:]),
            self.last_row.eq(self.v == order.height - 1),
        ]
        further_edge, further_last = limited(edge + self.strip)
        m.d.sync += [next_edge.eq(further_edge), next_last.eq(further_last)]
        with m.If(self.advance):
            m.d.sync += self.u.eq(self.u + self.lanes)
            with m.If(self.last_column & self.last_row):
                m.d.sync += [self.v.eq(0), left.eq(self.u + self.lanes),
                             edge.eq(next_edge), self.last_strip.eq(next_last)]
            with m.Elif(self.last_column):
                m.d.sync += [self.v.eq(self.v + 1), self.u.eq(left)]
        with m.If(self.start):
            first_edge, only = limited(self.strip - 1)
            m.d.sync += [self.u.eq(0), self.v.eq(0), left.eq(0),
                         edge.eq(first_edge), self.last_strip.eq(only)]
        return m
