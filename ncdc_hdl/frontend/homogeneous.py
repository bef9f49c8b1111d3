"""Scan of a view's nodes in homogeneous coordinates."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import exact_log2

from ncdc_hdl.frontend.layouts import EDGES, view_layout
from ncdc_spec.nodes import BEFORE
from ncdc_spec.view import FORMATS, SUM_BITS

__all__ = ["HomogeneousScan"]

_ORDER = 2, 0, 1        # rows of the matrix: the depth first, since its reciprocal takes long


class HomogeneousScan(wiring.Component):
    """Z, X and Y of the nodes of :class:`NodeScan`, one after the other, by one adder.

    Node k of row v has ``origin + k S u + v v`` of each row of the matrix, exact. Equal bit for bit
    to ``ncdc_model.golden.view.homogeneous``.

    Each of three words circulates through three registers: ``head``, operands of the adder, sum.
    A node moves them by three clocks, in which ``head`` shows Z, X, Y and each becomes that of the
    next node. Two more words of each coordinate circulate alike: that of the first node of the row,
    and that of the first node of the next strip.

    Timing: Z with ``issue``, X and Y in the two clocks after it. The next node may be issued 3
    clocks after the one before, a frame's first one ``latency`` clocks after ``start``.

    Parameters
    ----------
    nodes : int
        S.
    again : bool
        Whether rows may be scanned again.

    Members
    -------
    start : ``In(1)``
        Begins a frame; no node is under way.
    view : ``In(view_layout())``
        Constant from ``start`` to the end of the frame.
    issue : ``In(1)``
        A node is issued.
    edges : ``In(EDGES)``
        Of that node, constant for 3 clocks.
    again : ``In(1)``
        After its row the same row is scanned again; likewise (only with ``again``).
    o : ``Out(signed(SUM_BITS))``
    """

    latency = 4
    """Clocks from ``start`` to the first node: three words, and a clock before."""

    def __init__(self, nodes, again=False):
        self.nodes = nodes
        super().__init__({
            "start": In(1), "view": In(view_layout()), "issue": In(1), "edges": In(EDGES),
            "o": Out(signed(SUM_BITS)), **({"again": In(1)} if again else {})})

    def elaborate(self, platform):
        m = Module()
        shape = signed(SUM_BITS)
        slot = Signal(range(3))             # coordinate at ``head``, in the order of ``_ORDER``
        loading = Signal()                  # the frame's first node is computed
        move = Signal()                     # all words move on
        m.d.comb += move.eq(self.issue | loading | (slot != 0))
        with m.If(move):
            m.d.sync += slot.eq(Mux(slot == 2, 0, slot + 1))
        with m.If(slot == 2):
            m.d.sync += loading.eq(0)
        with m.If(self.start):
            m.d.sync += loading.eq(1)
        across, down, origin = self._steps(slot)
        if "again" in self.signature.members:
            down = Mux(self.again, 0, down)
        # Head: words of the node shown.
        head = Signal(shape)                # its coordinate
        head_row = Signal(shape)            # that of the row's first node
        head_strip = Signal(shape)          # that of the next strip's first node
        # Operands.
        a, b = Signal(shape), Signal(shape)
        minus = Signal()                    # b is the complement of what is subtracted
        row, strip = Signal(shape), Signal(shape)
        new_row = Signal()                  # the next node is the first of its row
        new_strip = Signal()                # the next node is the first of its strip
        # Sum.
        total, sum_row, sum_strip = Signal(shape), Signal(shape), Signal(shape)
        following = Signal(shape)           # the next node's coordinate
        assert BEFORE == 1
        ends = self.edges.last_column
        m.d.comb += [
            self.o.eq(head),
            following.eq(Mux(new_strip, strip, (Cat(minus, a).as_signed()
                                                + Cat(minus, b).as_signed()) >> 1)),
        ]
        with m.If(move):
            m.d.sync += [
                a.eq(Mux(loading, origin, Mux(ends, head_row, head))),
                b.eq(Mux(loading, ~across, Mux(ends, down, across))),
                minus.eq(loading), new_row.eq(loading | ends),
                new_strip.eq(~loading & ends & self.edges.last_row),
                row.eq(head_row), strip.eq(Mux(self.edges.next_strip, head, head_strip)),
                total.eq(following), sum_row.eq(Mux(new_row, following, row)), sum_strip.eq(strip),
                head.eq(total), head_row.eq(sum_row), head_strip.eq(sum_strip),
            ]
        return m

    def _steps(self, slot):
        """Growth from node to node, from row to row, and origin, of the coordinate of ``slot``."""
        words = []
        for number in _ORDER:
            step, _, q = FORMATS[number]
            u, v, origin = (self.view.matrix[number][k] for k in range(3))
            words.append((u << exact_log2(self.nodes), v, origin << step.f_bits - q.f_bits))
        return (Array(column)[slot] for column in zip(*words))
