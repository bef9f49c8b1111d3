"""From the nodes of a view's picture to their positions in the trained picture."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.frontend.homogeneous import HomogeneousScan
from ncdc_hdl.frontend.layouts import (
    EDGES,
    NODE_NUMBER,
    ROW_WRITES,
    SIZE,
    rows_layout,
    scan_layout,
    view_layout,
)
from ncdc_hdl.frontend.reciprocal import Reciprocal
from ncdc_hdl.frontend.row_matrices import RowMatrices
from ncdc_hdl.lib.pipeline import DelayMemory, delay, register
from ncdc_hdl.neural.product import Product
from ncdc_spec.geometry import SCAN
from ncdc_spec.reciprocal import RECIPROCAL_BITS
from ncdc_spec.view import DEPTH_SHIFTS, FORMATS, NODE, NUMERATOR, PLANE, SUM_BITS
from ncdc_spec.view_rows import ROW_BITS, ROW_SHIFT

__all__ = ["ViewTransform"]


def _cut(value, drop, width):
    """``value`` without its lowest ``drop`` bits, in ``width`` bits, and whether it fits."""
    rest = value[drop:]
    above = rest[width - 1:]
    return rest[:width].as_signed(), above.all() | ~above.any()


class ViewTransform(wiring.Component):
    """Normalised coordinates of a view's nodes in the trained picture, and their positions there.

    Equal bit for bit to ``ncdc_model.golden.view.node_positions``, except for what does not fit.

    Both axes take turns in one pipeline, x a clock ahead of y: shift like the depth, product with
    the depth's reciprocal, product with the scan's step. What comes from the :class:`NodeScan` is
    registered first, since ``i_issue`` is decided late in its clock and moves all words of the
    sums. Timing: free-running, ``latency`` clocks from ``i_issue`` to ``issue``. The positions are
    there ``latency - early`` clocks after ``i_issue``, for a clock.

    Parameters
    ----------
    q : ncdc_spec.fixed.Q
        Format of the network's input.
    nodes, interval : int
        As for :class:`NodeScan`; ``interval`` is at least 3.
    multiplier_bits : int
        Width of the multiplier blocks, 27 or 18.
    matrices : int
        Of the table down the raw frame, 0 without one; ``interval`` is then at least 6.

    Members
    -------
    start, parameters, view : ``In(1)``, ``In(scan_layout())``, ``In(view_layout())``
        Origins and steps of the scan are those of the trained picture.
    i_issue, i_whole, edges : ``In(1)``, ``In(1)``, ``In(EDGES)``
        Outputs of the :class:`NodeScan`.
    again, number, line, raw_row, rows, writes
        As in :class:`HomogeneousScan` and :class:`RowMatrices` (only with a table).
    issue, turn, whole, x, y : as in :class:`NodeScan`; ``turn`` counts on after a node
    column, row : ``Out(signed(NODE.width))``
        Positions in the trained picture, in pixels.
    fits : ``Out(1)``
        The node is in front of the camera, and nothing overflows; with x and y.
    """

    def __init__(self, q, nodes, interval, multiplier_bits=27, matrices=0):
        self.q = q
        self.scan = HomogeneousScan(nodes, again=matrices > 0)
        self.matrices = RowMatrices(nodes, matrices, multiplier_bits) if matrices else None
        self.reciprocal = Reciprocal(multiplier_bits)
        self.divide = Product(NUMERATOR.width, RECIPROCAL_BITS + 2, multiplier_bits)
        self.normalise = Product(PLANE.width, SCAN.width, multiplier_bits)
        number = Out(signed(q.width))
        super().__init__({
            "start": In(1), "parameters": In(scan_layout()), "view": In(view_layout()),
            "i_issue": In(1), "i_whole": In(1), "edges": In(EDGES),
            "issue": Out(1), "turn": Out(range(interval)), "whole": Out(1), "x": number,
            "y": number, "column": Out(signed(NODE.width)), "row": Out(signed(NODE.width)),
            "fits": Out(1),
            **({"again": In(1), "number": In(NODE_NUMBER), "line": In(SIZE),
                "raw_row": In(ROW_BITS), "rows": In(rows_layout()), "writes": In(ROW_WRITES)}
               if matrices else {})})

    @property
    def _moved(self):
        """Clocks from the issue to the sums with those of the table: its register, these, a sum."""
        return 1 + (self.matrices.latency + 1 if self.matrices else 0)

    @property
    def _divided(self):
        """Clocks from the issue to the position of x: sums, reciprocal, product, rounding."""
        return self._moved + self.reciprocal.latency + self.divide.latency + 1

    @property
    def latency(self):
        """Clocks: position of x, product, sum, y a clock later, output."""
        return self._divided + self.normalise.latency + 1 + 1 + 1

    @property
    def early(self):
        """Clocks from the positions, that of x delayed by a clock, to ``issue``."""
        return self.latency - self._divided - 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan, m.submodules.reciprocal = scan, reciprocal = self.scan, self.reciprocal
        m.d.comb += [
            scan.start.eq(self.start), scan.view.eq(self.view),
            Value.cast(scan.edges).eq(register(m, "edges_entered", Value.cast(self.edges))),
            scan.issue.eq(register(m, "issue_entered", self.i_issue, reset_less=False)),
        ]
        total = self._move(m) if self.matrices else scan.o
        m.d.comb += [reciprocal.z.eq(total), reciprocal.valid.eq(delay(
            m, self.i_issue, self._moved, "moved_issue", reset_less=False))]
        position, fits, of_y = self._divide(m, total)
        m.d.comb += [
            self.column.eq(register(m, "column_before", position >> PLANE.f_bits - NODE.f_bits)),
            self.row.eq(position >> PLANE.f_bits - NODE.f_bits),
        ]
        value, fits, of_y = self._normalise(m, position, fits, of_y)
        # Output: x has waited for y.
        before = register(m, "x_before", Cat(value, fits))
        with m.If(of_y):
            m.d.sync += [self.x.eq(before[:-1]), self.y.eq(value), self.fits.eq(before[-1] & fits)]
        issues = delay(m, self.i_issue, self.latency - 1, "issue", reset_less=False)
        m.d.sync += [self.issue.eq(issues), self.turn.eq(Mux(issues, 0, self.turn + 1))]
        m.d.comb += self.whole.eq(delay(m, self.i_whole, self.latency, "whole"))
        return m

    def _move(self, m):
        """Z, X and Y of a node with what the table adds."""
        m.submodules.matrices = matrices = self.matrices
        wiring.connect(m, wiring.flipped(self.writes), matrices.writes)
        m.submodules.sums = sums = DelayMemory(signed(SUM_BITS), matrices.latency)
        used = register(m, "rows_used", self.rows.count != 0)
        m.d.comb += [
            self.scan.again.eq(register(m, "again_entered", self.again)),
            matrices.issue.eq(self.scan.issue),
            matrices.number.eq(register(m, "number_entered", self.number)),
            matrices.line.eq(register(m, "line_entered", self.line)),
            matrices.row.eq(register(m, "raw_row_entered", self.raw_row)),
            matrices.rows.eq(self.rows), sums.i.eq(self.scan.o),
        ]
        return register(m, "moved", sums.o + (Mux(used, matrices.o, 0) << ROW_SHIFT),
                        signed(SUM_BITS))

    def _divide(self, m, total):
        """Position of x, then y, whether it fits, and whether it is that of y.

        ``total``: Z, X and Y, one after the other.
        """
        reciprocal = self.reciprocal
        m.submodules.divide = divide = self.divide
        # Shift like the depth; whether the numerator fits is known before.
        drop = FORMATS[0][0].f_bits - NUMERATOR.f_bits
        shifted = (total << reciprocal.shifts)[drop:drop + NUMERATOR.width]
        holds = Array(_cut(total, 0, drop + NUMERATOR.width - shifts)[1]
                      for shifts in range(DEPTH_SHIFTS + 1))[reciprocal.shifts]
        numerator = register(m, "numerator", Cat(shifted, holds & reciprocal.inside))
        # Wait for the reciprocal. That of the next node comes after both axes have used it.
        m.submodules.waiting = waiting = DelayMemory(len(numerator), reciprocal.latency - 2)
        m.d.comb += [waiting.i.eq(numerator), divide.a.eq(waiting.o[:-1]),
                     divide.b.eq(reciprocal.o)]
        shift = NUMERATOR.f_bits + RECIPROCAL_BITS - PLANE.f_bits
        position, holds = _cut(divide.o + (1 << shift - 1), shift, PLANE.width)
        fits = delay(m, waiting.o[-1], divide.latency, "divide_fits")
        return (register(m, "position", position), register(m, "position_fits", fits & holds),
                delay(m, self.i_issue, self._divided + 1, "position_of_y"))

    def _normalise(self, m, position, fits, of_y):
        """Normalised coordinate of a ``position``, whether it fits, and whether it is that of y."""
        p = self.parameters
        m.submodules.normalise = normalise = self.normalise
        shift = SCAN.f_bits - self.q.f_bits
        m.d.comb += [normalise.a.eq(position), normalise.b.eq(Mux(of_y, p.step_y, p.step_x))]
        # Below a bit of the origin nothing is added to the product.
        late = delay(m, of_y, normalise.latency, "normalise_of_y")
        origins = [register(m, f"rounded_origin{k}", origin + (1 << shift - 1))
                   for k, origin in enumerate((p.origin_x, p.origin_y))]
        total = register(m, "normalised", (normalise.o >> PLANE.f_bits) + Mux(late, *origins[::-1]))
        value, holds = _cut(total, shift, self.q.width)
        return (value, delay(m, fits, normalise.latency + 1, "normalise_fits") & holds,
                delay(m, of_y, normalise.latency + 1, "value_of_y"))
