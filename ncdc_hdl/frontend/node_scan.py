"""Scan of the corrected image's nodes in normalised coordinates."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.layouts import EDGES, NODE_NUMBER, SIZE, scan_layout
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.geometry import MAX_SIZE, SCAN, STRIP_UNIT
from ncdc_spec.nodes import AFTER, BEFORE
from ncdc_spec.view_rows import SETTLING

__all__ = ["NodeScan"]

_COUNT = range(-MAX_SIZE - 1, MAX_SIZE)     # range of counts down to -1


class NodeScan(wiring.Component):
    """The nodes of every row of every strip as normalised coordinates.

    The order is that of :class:`ncdc_hdl.frontend.strips.Strips`. A row of n segments of S pixels,
    the last one shorter, has the n + 1 nodes at their ends, one before and one after these::

        x = (origin_x + (left + k S) step_x + half) >> shift      k = -1 .. n + 1
        y = (origin_y + v step_y + half) >> shift                 shift = 31 - input.f_bits

    Equal bit for bit to ``ncdc_model.golden.network.normalised_scan``. By addition only: a strip's
    first node is the third from the end of the strip before.

    Timing: each node is shown until ``interval`` clocks after its ``issue``. ``start`` to the first
    node takes ``latency`` clocks.

    Parameters
    ----------
    formats : ncdc_spec.descriptor.Formats
        Formats at nodes; ``input`` is used.
    nodes : int
        S, at least 8.
    interval : int
        Clocks per node, at least 2: the next one's coordinates are added up meanwhile.
    view : bool
        Whether other hardware computes the coordinates, of a view; the scan then has none.
    rows : bool
        Whether nodes need a result of the node above, of a view. A strip's first row then comes
        ``SETTLING`` times more before.

    Members
    -------
    start : ``In(1)``
        Begins a frame; allowed only while no node of the last one is under way.
    stop : ``In(1)``
        No further node is issued.
    parameters : ``In(scan_layout())``
        Constant from ``start`` to the end of the frame. Its picture is wider than 4 S.
    space : ``In(1)``
        A node may be issued in the next clock.
    issue : ``Out(1)``
        The node shown enters the network, in turn 0.
    turn : ``Out(range(interval))``
        0 with ``issue``, then incremented each clock.
    x, y : ``Out(signed(formats.input.width))``
        Only without a view.
    edges : ``Out(EDGES)``
        Of the node shown (only with a view).
    whole : ``Out(1)``
        Three nodes of its row precede the one shown: the four surround a segment. Low in a row that
        comes again.
    ready : ``In(1)``
        The result of the node above is there (this and all further ones only with ``rows``).
    top, bottom, again : ``Out(1)``
        The node shown is in the strip's first row, in its last one, in one that comes again.
    number, line : ``Out(NODE_NUMBER)``, ``Out(SIZE)``
        Its column in S, and its row.

    Raises
    ------
    ValueError
        If ``interval`` is below 2.
    """

    latency = 5
    """Clocks from ``start`` to the first node: number of nodes in 4, the node."""

    def __init__(self, formats, nodes, interval, view=False, rows=False):
        if interval < 2:
            raise ValueError(f"interval is {interval} clocks, a node takes at least 2")
        self.q, self.nodes, self.interval, self.rows = formats.input, nodes, interval, rows
        number = Out(signed(self.q.width))
        super().__init__({
            "start": In(1), "stop": In(1), "parameters": In(scan_layout()), "space": In(1),
            "issue": Out(1), "turn": Out(range(interval)),
            **({"edges": Out(EDGES)} if view else {"x": number, "y": number}), "whole": Out(1),
            **({"ready": In(1), "top": Out(1), "bottom": Out(1), "again": Out(1),
                "number": Out(NODE_NUMBER), "line": Out(SIZE)} if rows else {}),
        })

    def elaborate(self, platform):
        m = Module()
        active = Signal()               # a node is shown
        advance = Signal()              # another node is shown in the next clock
        begin = Signal()                # it is the frame's first one
        column = Signal(_COUNT)         # nodes of the row after the one shown, less one
        row = Signal(_COUNT)            # rows of the strip after this one, less one
        rows = Signal(_COUNT)           # rows of the picture, less two
        row_ends = Signal()             # the node shown is left, the last of its row
        strip_ends = Signal()           # the node shown is left, the last of its strip
        before = Signal(2)              # nodes of the row before the one shown, at most 3
        m.d.sync += rows.eq(self.parameters.height - (2 - SETTLING if self.rows else 2))
        per_row, last_strip = self._strip(m, begin | strip_ends)
        m.d.comb += [
            begin.eq(delay(m, self.start, self.latency - 1, "start", reset_less=False)),
            row_ends.eq(advance & (column < 0)), strip_ends.eq(row_ends & (row < 0)),
        ]
        three = self.whole              # three nodes of the row precede the one shown
        if self.rows:
            three = Signal()
            m.d.comb += self.whole.eq(three & ~self.again)
        m.d.comb += three.eq(before == 3)
        self._pace(m, active, advance)
        with m.If(advance):
            m.d.sync += [column.eq(column - 1), before.eq(Mux(three, 3, before + 1))]
        with m.If(row_ends):
            m.d.sync += row.eq(row - 1)
        with m.If(strip_ends | begin):
            m.d.sync += row.eq(rows)
        with m.If(row_ends | begin):
            m.d.sync += [column.eq(per_row), before.eq(0)]
        with m.If(strip_ends & last_strip | self.stop):
            m.d.sync += active.eq(0)
        with m.If(begin & ~self.stop):
            m.d.sync += active.eq(1)
        saves = column == BEFORE + AFTER - 2
        if "edges" in self.signature.members:
            first_row = Signal()        # the row is the first of its strip
            with m.If(row_ends | begin):
                m.d.sync += first_row.eq(strip_ends | begin)
            m.d.comb += [self.edges.last_column.eq(column < 0), self.edges.last_row.eq(row < 0),
                         self.edges.next_strip.eq(saves & first_row)]
            if self.rows:
                m.d.comb += [self.top.eq(first_row), self.bottom.eq(self.edges.last_row)]
                self._rows(m, begin, advance, row_ends, strip_ends, saves)
        else:
            self._coordinates(m, begin, advance, row_ends, strip_ends, saves=active & saves)
        return m

    def _pace(self, m, active, advance):
        """A node enters the network when there is space, and is held for ``interval`` turns."""
        may = register(m, "may", self.space, reset_less=False)
        if self.rows:
            may = may & (self.top | self.ready)
        goes_on = self.issue | (self.turn != 0)
        m.d.comb += self.issue.eq(active & may & (self.turn == 0))
        # The last turn, known a clock ahead.
        m.d.sync += advance.eq(goes_on & (self.turn == self.interval - 2))
        with m.If(goes_on):
            m.d.sync += self.turn.eq(Mux(advance, 0, self.turn + 1))

    def _rows(self, m, begin, advance, row_ends, strip_ends, saves):
        """Number and row of the node, and whether its row comes again."""
        left = Signal(range(SETTLING + 1))  # times that the row comes again
        base = Signal(NODE_NUMBER)          # number of the strip's first node
        saved = Signal(NODE_NUMBER)         # number of the next strip's first node
        m.d.comb += self.again.eq(left != 0)
        with m.If(saves):
            m.d.sync += saved.eq(self.number)
        with m.If(advance):
            m.d.sync += self.number.eq(self.number + 1)
        with m.If(row_ends):
            m.d.sync += self.number.eq(base)
            with m.If(self.again):
                m.d.sync += left.eq(left - 1)
            with m.Else():
                m.d.sync += self.line.eq(self.line + 1)
        with m.If(strip_ends):
            m.d.sync += [self.number.eq(saved), base.eq(saved)]
        with m.If(begin):
            m.d.sync += [self.number.eq(-BEFORE), base.eq(-BEFORE)]
        with m.If(strip_ends | begin):
            m.d.sync += [self.line.eq(0), left.eq(SETTLING)]

    def _strip(self, m, taken):
        """Initial value of ``column`` in a row, and whether the strip is the last one.

        The next strip's numbers are computed in the three clocks after the one in which it is
        ``taken``. Those of a frame's first strip before it begins.
        """
        p, unit = self.parameters, exact_log2(STRIP_UNIT)
        strip = Cat(Const(0, unit), p.strip[unit:])
        columns = Signal(_COUNT)        # columns from the strip to come to the right edge
        beyond = Signal(_COUNT)         # those of the strip after it, or none
        is_last = Signal()              # the strip to come is the last one
        wide = Signal(_COUNT)           # its columns
        initial = Signal(_COUNT)        # initial value of `column` in its rows
        per_row = Signal(_COUNT)        # initial value in rows of this strip
        last_strip = Signal()           # this strip is the last one
        m.d.sync += [
            # Cycle 1: subtract the strip's columns from the remaining ones.
            beyond.eq(columns - strip),
            # Cycle 2: the last strip has the rest.
            is_last.eq((strip == 0) | (beyond <= 0)),
            wide.eq(Mux((strip == 0) | (beyond <= 0), columns, strip)),
            # Cycle 3: count the nodes, less the one shown, and down to -1.
            initial.eq(((wide + self.nodes - 1) >> exact_log2(self.nodes)) + (BEFORE + AFTER - 2)),
        ]
        with m.If(taken):
            m.d.sync += [per_row.eq(initial), last_strip.eq(is_last), columns.eq(beyond)]
        with m.If(self.start):
            m.d.sync += columns.eq(p.width)
        # With the node that ends a strip, the next strip's first row begins.
        return Mux(taken, initial, per_row), last_strip

    def _coordinates(self, m, begin, advance, row_ends, strip_ends, saves):
        """Sums of origin, steps and the half that rounds; the next node's is a clock early."""
        p, q = self.parameters, self.q
        shift = SCAN.f_bits - q.f_bits
        half, shape = 1 << (shift - 1), signed(q.width + shift)
        stride = p.step_x << exact_log2(self.nodes)     # step of x from node to node
        first_x = Signal(shape)         # x of the picture's first node, and the half
        first_y = Signal(shape)         # y of its first row, and the half
        base = Signal(shape)            # x of the strip's first node
        saved = Signal(shape)           # x of the next strip's first node
        x, y = Signal(shape), Signal(shape)
        further = Signal(shape)         # x of the next node of the row
        below = Signal(shape)           # y of the next row
        m.d.sync += [
            first_x.eq(p.origin_x + half - BEFORE * stride), first_y.eq(p.origin_y + half),
            further.eq(x + stride), below.eq(y + p.step_y),
        ]
        with m.If(saves):
            m.d.sync += saved.eq(x)
        with m.If(advance):
            m.d.sync += x.eq(further)
        with m.If(row_ends):
            m.d.sync += [x.eq(base), y.eq(below)]
        with m.If(strip_ends):
            m.d.sync += [x.eq(saved), base.eq(saved), y.eq(first_y)]
        with m.If(begin):
            m.d.sync += [x.eq(first_x), base.eq(first_x), y.eq(first_y)]
        m.d.comb += [self.x.eq(x >> shift), self.y.eq(y >> shift)]
