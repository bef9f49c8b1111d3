"""The order of the corrected pixels: raster, or strips of columns."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.layouts import SIZE
from ncdc_hdl.lib.pipeline import delay
from ncdc_spec.geometry import MAX_SIZE, STRIP_UNIT

__all__ = ["ORDER", "Strips"]

# Columns and rows of a picture, and columns of a strip; 0 if the picture is one strip.
ORDER = data.StructLayout({"width": SIZE, "height": SIZE, "strip": SIZE})

_COUNT = range(-MAX_SIZE - 1, MAX_SIZE)     # range of counts down to -1


class Strips(wiring.Component):
    """Counts through a picture: strips left to right, rows top down, columns left to right.

    A strip has ``order.strip`` columns, the last one the rest. A width of 0 makes the whole
    picture one strip: a raster. Equal to ``ncdc_spec.geometry.scan_order``.

    Groups and rows are counted down to -1, so that the sign marks the last one without a
    comparison.

    Timing: all outputs but ``strip`` and ``raster`` belong to one group, and change to the next one
    in the clock after ``advance``. The parent requests a frame's first group by an ``advance`` in
    the clock of ``begin``; it comes ``latency`` clocks after ``start``. A picture's width must
    not be 0.

    Parameters
    ----------
    lanes : int
        Pixels of a group, counted together; a power of two, at most ``STRIP_UNIT / 8``. The width
        of the picture must be a multiple of it.

    Members
    -------
    order : ``In(ORDER)``
        Sizes in pixels, constant from ``start`` on. Bits below ``STRIP_UNIT`` of the strip's width
        are ignored.
    start : ``In(1)``
        Begins a frame.
    advance : ``In(1)``
        Another group is output in the next clock.
    soon : ``Out(1)``
        High in the clock before ``begin``.
    begin : ``Out(1)``
        High in the clock in which the parent must ``advance`` for the first group.
    u : ``Out(SIZE)``
        Column of the group's leftmost pixel.
    last_column : ``Out(1)``
        The group is the last of its row within the strip.
    last_row : ``Out(1)``
        The group's row is the last of the picture.
    last_strip : ``Out(1)``
        The group's strip is the last one.
    strip : ``Out(SIZE)``
        Columns of each strip but the last; 0 if there is only one.
    raster : ``Out(1)``
        The whole picture is one strip.
    """

    latency = 6
    """Clocks from ``start`` to the first group: the strip's sizes in 4, ``begin``, the group."""

    def __init__(self, lanes=1):
        self.lanes = lanes
        super().__init__({
            "order": In(ORDER),
            "start": In(1),
            "advance": In(1),
            "soon": Out(1),
            "begin": Out(1),
            "u": Out(SIZE),
            "last_column": Out(1),
            "last_row": Out(1),
            "last_strip": Out(1),
            "strip": Out(SIZE),
            "raster": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        order = self.order
        unit = exact_log2(STRIP_UNIT)
        left = Signal(SIZE)             # first column of the strip
        column = Signal(_COUNT)         # groups of the row after this one, less one
        row = Signal(_COUNT)            # rows of the strip after this one, less one
        rows = Signal(_COUNT)           # rows of the picture, less two
        further = Signal(SIZE)          # `u` of the group on the right
        next_strip = Signal()           # the strip's last group ends
        m.d.comb += [
            self.strip.eq(Cat(Const(0, unit), order.strip[unit:])),
            self.raster.eq(self.strip == 0),
            self.last_column.eq(column < 0), self.last_row.eq(row < 0),
            next_strip.eq(self.advance & self.last_column & self.last_row),
        ]
        m.d.comb += self.soon.eq(delay(m, self.start, self.latency - 2, "start", reset_less=False))
        m.d.sync += self.begin.eq(self.soon)
        row_groups = self._strip_to_come(m, next_strip)
        m.d.sync += rows.eq(order.height - 2)
        m.d.comb += further.eq(self.u + self.lanes)
        with m.If(self.advance):
            m.d.sync += [
                column.eq(Mux(self.last_column, row_groups, column - 1)),
                self.u.eq(Mux(self.last_column & ~self.last_row, left, further)),
            ]
        with m.If(self.advance & self.last_column):
            m.d.sync += row.eq(Mux(self.last_row, rows, row - 1))
        with m.If(next_strip):
            m.d.sync += left.eq(further)
        with m.If(self.start):
            # Same as at the end of a strip to the left of the picture.
            m.d.sync += [column.eq(-1), row.eq(-1), self.u.eq(-self.lanes)]
        return m

    def _strip_to_come(self, m, next_strip):
        """Compute the next strip; return the initial value of ``column`` in a row.

        This takes three clocks from the columns right of the strip's first one, and a fourth for
        the row. Only the last strip can have rows of so few groups.
        """
        group = exact_log2(self.lanes)
        columns = Signal(_COUNT)        # columns from the strip to come to the right edge, less one
        groups = Signal(_COUNT)         # groups in a row of the present strip, less two
        beyond = Signal(_COUNT)         # `columns` of the strip after that; negative if none is
        last = Signal(1)                # the strip to come is the last one
        less_one = Signal(_COUNT)       # groups in a row of the strip to come, less one
        less_two = Signal(_COUNT)       # groups in a row of the strip to come, less two
        row_groups = Signal(_COUNT)     # groups in the row to come, less two
        m.d.sync += [
            # Cycle 1: subtract the strip's columns from the remaining ones.
            beyond.eq(columns - self.strip),
            # Cycle 2: if none remain it is the last strip, with the columns before the subtraction.
            last.eq(self.raster | (beyond < 0)),
            less_one.eq(Mux(self.raster | (beyond < 0), columns, self.strip - 1) >> group),
            # Cycle 3: count down to -1, not to 0.
            less_two.eq(less_one - 1),
            # Cycle 4: choose by whether the row to come is in the present strip.
            row_groups.eq(Mux(self.last_row, less_two, groups)),
        ]
        with m.If(next_strip):
            m.d.sync += [groups.eq(less_two), columns.eq(beyond), self.last_strip.eq(last)]
        with m.If(self.start):
            m.d.sync += columns.eq(self.order.width - 1)
        return row_groups
