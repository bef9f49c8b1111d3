"""Cuts a window out of the samples of the tile memory."""

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.tiles import samples_layout
from ncdc_hdl.backend.layouts import edges
from ncdc_hdl.lib.choice import chosen
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["align_for"]


def align_for(columns, interpolation):
    """The class that cuts the windows of ``interpolation`` out of ``columns`` samples of a row."""
    return (AlignMirrored if interpolation.margin else Align)(columns, interpolation)


class _Align(wiring.Component):
    """Samples of a window, from samples that are ordered by x and y modulo the box::

        o[k] = samples[(y - margin + j) mod M][(x - margin + i) mod columns]

    for each (j, i) of ``interpolation.samples``.

    Timing: ``latency`` clocks from the samples to ``o``. Position and edges come a clock before the
    samples that they belong to.

    Members
    -------
    take : ``In(2)``
        Whether ``o`` loads the output of the last stage but one, a bit for each half of its
        samples; the others free-run.
    samples : ``In(samples_layout(columns, interpolation))``
    x, y : ``In``
        Low bits of the sample of the first point.
    edge_x, edge_y : ``In(edge_layout(interpolation))``
        Missing columns and rows, for windows with a margin.
    odd_rows : ``In(1)``
        Whether the even rows of the samples are odd ones, see ``Tiles``, for windows with a margin.
    o : ``Out(ArrayLayout(8, n))``
    """

    def __init__(self, columns, interpolation):
        self.columns, self.interpolation = columns, interpolation
        layouts = edges(interpolation)
        super().__init__({
            "take": In(2),
            "samples": In(samples_layout(columns, interpolation)),
            "x": In(ceil_log2(TILE_WIDTH)),
            "y": In(ceil_log2(interpolation.box_rows)),
            "o": Out(data.ArrayLayout(8, len(interpolation.samples))),
        } | {name: In(layout) for name, layout in layouts.items()}
            | ({"odd_rows": In(1)} if layouts else {}))


class Align(_Align):
    __doc__ = _Align.__doc__ + """
    Windows without a margin: the first stage chooses rows, the second one bytes.
    """

    latency = 2

    def elaborate(self, platform):
        m = Module()
        window, rows = self.interpolation.window, self.interpolation.box_rows
        byte = delay(m, self.x[:ceil_log2(self.columns)], 2, "byte")
        for j in range(window):
            which = register(m, f"which{j}", (self.y + j)[:ceil_log2(rows)])
            row = register(m, f"row{j}", Value.cast(self.samples[which]))
            # The last word is followed by the first one.
            around = Cat(row, row)
            with m.If(self.take[j % 2]):
                m.d.sync += Cat(*(self.o[window * j + k] for k in range(window))).eq(
                    Cat(around.word_select(byte + k, 8) for k in range(window)))
        return m


class AlignMirrored(_Align):
    __doc__ = _Align.__doc__ + """
    Windows with a margin, whose samples outside the frame are mirrored about its first or last
    column or row. A sample and its mirror image are an even number of positions apart. Windows come
    reflected, so that their even columns are even ones of the frame, and their even rows
    even ones of the samples. Eight neighbouring columns, and rows, hold a window: each sample of it
    is in one of four columns and one of four rows. The first stage chooses, of the columns that are
    the same modulo 8, one; the second one rows, the third one columns. Each chooses from
    at most four bits for each bit: this fits a look-up table of common devices. The last stage
    chooses nothing: it is where windows wait.
    """

    latency = 4

    def elaborate(self, platform):
        m = Module()
        needs = self.interpolation
        ring = needs.box_rows                   # columns that are chosen, as many as rows
        bits = ceil_log2(ring)

        staged = partial(register, m)
        # The first column and row of the window, their low bits.
        across = self.columns // ring      # rings side by side in the samples
        column, row = Signal(bits + ceil_log2(across)), Signal(bits)
        m.d.comb += [column.eq(self.x - needs.margin), row.eq(self.y - needs.margin)]
        # Stage 1: the columns from the window's first one on.
        near = [[] for _ in self.samples]
        for k in range(ring):
            # Ring that has the window's column k modulo 8.
            which = staged(f"which{k}", column[bits:] + (column[:bits] > k if k < ring - 1 else 0),
                           unsigned(ceil_log2(across)))
            for j, samples in enumerate(self.samples):
                near[j].append(staged(f"w_{j}{k}", chosen(list(samples)[k::ring], which)))
        w_rows = self._positions(m, "w_row", staged("s_row", row), staged("s_edge_y", self.edge_y),
                                 self.odd_rows)
        # Stage 2: the rows.
        rows = [staged(f"r_{j}", chosen([Cat(each) for each in near[j % 2::2]], position))
                for j, position in enumerate(w_rows)]
        r_columns = self._positions(m, "r_column", delay(m, column[:bits], 2, "column"),
                                    delay(m, self.edge_x, 2, "edge_x"))
        # Stage 3: the columns.
        for k, (j, i) in enumerate(needs.samples):
            values = [rows[j].word_select(n, 8) for n in range(i % 2, ring, 2)]
            sample = staged(f"c_{j}{i}", chosen(values, r_columns[i]))
            with m.If(self.take[k % 2]):
                m.d.sync += self.o[k].eq(sample)
        return m

    def _positions(self, m, name, first, edge, odd=Const(0)):
        """For each column or row of the window, its position among four, a clock later.

        ``first``: where the window begins, modulo 8. It is reflected unless ``odd`` says that this
        is odd.
        """
        found, last = [], self.interpolation.window - 1
        reflected = Signal(name=f"{name}_reflected")
        m.d.comb += reflected.eq(first[0] ^ odd)
        for k in range(last + 1):
            position = Signal(len(first) - 1, name=f"{name}{k}_position")
            inside = Mux(reflected, self._inside(last - k, edge)[1:], self._inside(k, edge)[1:])
            # Both first and the column inside are odd: a carry.
            carry = first[0] & (~reflected if k % 2 else reflected)
            m.d.comb += position.eq(first[1:] + inside + carry)
            found.append(register(m, f"{name}{k}", position))
        return found

    def _inside(self, k, edge):
        """Row or column k of the window; outside the frame its mirror image inside."""
        margin, last = self.interpolation.margin, self.interpolation.window - 1
        value = Const(k, ceil_log2(last + 1))
        for missing in range(1, margin + 1):
            if k < missing:
                value = Mux((edge.missing == missing) & ~edge.after, 2 * missing - k, value)
            if last - k < missing:
                value = Mux((edge.missing == missing) & edge.after, 2 * (last - missing) - k,
                            value)
        return value
