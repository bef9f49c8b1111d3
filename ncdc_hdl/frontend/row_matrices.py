"""The table of matrices down the raw frame: what it adds to the nodes of a view."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2, exact_log2

from ncdc_hdl.frontend.layouts import NODE_NUMBER, ROW_WRITES, SIZE, rows_layout
from ncdc_hdl.lib.memory import block_memory
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_hdl.neural.product import Product
from ncdc_spec.view_rows import NUMBER_BITS, ROW_BITS, SHARE_BITS, STEP_SHIFT, STEPS

__all__ = ["RowMatrices"]

_READ = 2               # clocks from an address to the memory's output register
_SUM_BITS = 31          # of what a matrix adds to a coordinate
_DEPTH = 2              # row of a matrix that is the depth, the first one to be computed


class RowMatrices(wiring.Component):
    """What a table of matrices adds to Z, X and Y of a node, one after the other.

    Equal bit for bit to ``ncdc_model.golden.view_rows.added``, but for the shift by ``ROW_SHIFT``.

    The coordinates are computed by two neighbouring matrices, and interpolated: by the first one in
    three clocks, by the second in three more. Two products and two sums serve both. A third product
    weighs the difference. Timing: Z is at ``o`` ``latency`` clocks after ``issue``, X and Y in the
    clocks after it. Nodes are at least 6 clocks apart.

    Parameters
    ----------
    nodes : int
        S.
    matrices : int
        Of the table, which has them twice.
    multiplier_bits : int
        Width of the multiplier blocks, 27 or 18.

    Members
    -------
    issue : ``In(1)``
        A node is issued.
    number, line : ``In(NODE_NUMBER)``, ``In(SIZE)``
        Its number in the row, and the row; constant for 4 clocks from ``issue`` on.
    row : ``In(ROW_BITS)``
        Raw row that selects its matrix, with ``issue``.
    rows : ``In(rows_layout())``
        Constant during a frame.
    writes : ``In(ROW_WRITES)``
    o : ``Out(signed(32))``
    """

    def __init__(self, nodes, matrices, multiplier_bits=27):
        self.shift, self.matrices = exact_log2(nodes), matrices
        self.across = Product(NUMBER_BITS, Shape.cast(NODE_NUMBER).width, multiplier_bits)
        self.down = Product(NUMBER_BITS, Shape.cast(SIZE).width + 1, multiplier_bits)
        self.weigh = Product(NUMBER_BITS, SHARE_BITS + 1, multiplier_bits)
        super().__init__({
            "issue": In(1), "number": In(NODE_NUMBER), "line": In(SIZE), "row": In(ROW_BITS),
            "rows": In(rows_layout()), "writes": In(ROW_WRITES), "o": Out(signed(_SUM_BITS + 1))})

    @property
    def _summed(self):
        """Clocks to the first coordinate by the first matrix: step, limit, memory, product, sums.
        """
        return 2 + _READ + self.across.latency + 2

    @property
    def latency(self):
        """Clocks: coordinate by the first matrix, by the second, product, sum."""
        return self._summed + 3 + self.weigh.latency + 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.across, m.submodules.down = across, down = self.across, self.down
        m.submodules.weigh = weigh = self.weigh
        begun = [self.issue]                # by the clocks since the issue
        for k in range(self._summed + 3):
            begun.append(register(m, f"begun{k}", begun[-1], reset_less=False))
        address, share = self._matrix(m, begun)
        u, v, origin = (self._memory(m, k, address) for k in range(3))
        # Products with the node's column and row, which stay for both matrices.
        number, line = Signal(NODE_NUMBER), Signal(SIZE)
        with m.If(begun[1 + _READ]):
            m.d.sync += [number.eq(self.number), line.eq(self.line)]
        m.d.comb += [across.a.eq(u), across.b.eq(number),
                     down.a.eq(v), down.b.eq(Cat(line, Const(0, 1)).as_signed())]
        steps = register(m, "steps", (across.o << self.shift) + down.o)
        total = register(m, "total", (steps >> STEP_SHIFT)
                         + delay(m, origin, across.latency + 1, "origin"), signed(_SUM_BITS))
        # The second matrix's coordinate, 3 clocks after the first one's.
        first = delay(m, total, 3, "first")
        m.d.comb += [weigh.a.eq((total - first)[:NUMBER_BITS].as_signed()),
                     weigh.b.eq(Cat(share, Const(0, 1)).as_signed())]
        m.d.sync += self.o.eq(delay(m, first, weigh.latency, "late_first")
                              + (weigh.o >> SHARE_BITS))
        return m

    def _matrix(self, m, begun):
        """Address of a row of a matrix, from 2 clocks after the issue on, and the share of the
        second matrix, when both have computed Z."""
        finest = exact_log2(STEPS[-1] // STEPS[0])
        at = Signal(ROW_BITS + finest)      # raw row in steps
        last = register(m, "last_matrix", (self.rows.count - 1)[:len(self.rows.count)])
        beyond = Signal()
        k = Signal(ceil_log2(self.matrices))
        row = Signal(range(3))              # of the matrix
        second = Signal()                   # the second matrix is read
        share = [Signal(SHARE_BITS, name=f"share{k}", reset_less=True) for k in range(3)]
        with m.If(begun[0]):
            m.d.sync += at.eq((self.row << finest) >> self.rows.step)
        m.d.comb += beyond.eq(at[SHARE_BITS:] >= last)
        m.d.sync += row.eq(Mux(row == _DEPTH, 0, row + 1))
        with m.If(begun[1]):
            m.d.sync += [k.eq(Mux(beyond, last, at[SHARE_BITS:])), row.eq(_DEPTH), second.eq(0),
                         share[0].eq(Mux(beyond, 0, at[:SHARE_BITS]))]
        with m.If(begun[4]):
            m.d.sync += second.eq(1)
        # The share waits for the coordinates, in a register for each node under way.
        for clock, before, after in ((7, *share[:2]), (self._summed + 2, *share[1:])):
            with m.If(begun[clock]):
                m.d.sync += after.eq(before)
        return Cat(row, (k + second)[:len(k)], self.rows.bank), share[-1]

    def _memory(self, m, column, address):
        """The numbers of a column of the matrices, ``_READ`` clocks after their ``address``."""
        writes, bits = self.writes, ceil_log2(self.matrices)
        m.submodules[f"memory{column}"] = memory = block_memory(
            signed(NUMBER_BITS), 8 << bits)
        write, read = memory.write_port(), memory.read_port()
        # A frame's bank is not written: no word is read when it is written.
        m.d.comb += [
            write.addr.eq(Cat(writes.row, writes.matrix[:bits], writes.bank)),
            write.data.eq(writes.word),
            write.en.eq(writes.write & (writes.column == column)
                        & (writes.matrix < self.matrices)),
            read.addr.eq(address),
        ]
        return register(m, f"number{column}", read.data)
