"""Cuts a window out of the samples of the tile memory."""

from functools import partial

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.tiles import COLUMNS, samples_layout
from ncdc_hdl.backend.layouts import edges
from ncdc_hdl.lib.choice import chosen
from ncdc_hdl.lib.pipeline import delay, register
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["align_for"]


def align_for(word_bytes, interpolation):
    """The class that cuts the windows of ``interpolation`` out of words of ``word_bytes`` bytes."""
    return (AlignMirrored if interpolation.margin else Align)(word_bytes, interpolation)


class _Align(wiring.Component):
    """Samples of a window, from samples that are ordered by x and y modulo the box::

        o[k] = samples[(y - margin + j) mod M][(x - margin + i) mod (2 word_bytes)]

    for each (j, i) of ``interpolation.samples``.

    Timing: ``latency`` clocks from the samples to ``o``. All but ``take`` and the samples comes a
    clock before the samples that it belongs to.

    Members
    -------
    take : ``In(1)``
        Whether ``o`` loads the output of the last stage but one; the others free-run.
    samples : ``In(samples_layout(word_bytes, interpolation))``
    x, y : ``In``
        Low bits of the sample of the first point.
    edge_x, edge_y : ``In(edge_layout(interpolation))``
        Missing columns and rows, for windows with a margin.
    flip : ``In(1)``
        Whether the columns come right to left, for windows with a margin.
    o : ``Out(ArrayLayout(8, n))``
    """

    def __init__(self, word_bytes, interpolation):
        self.word_bytes, self.interpolation = word_bytes, interpolation
        layouts = edges(interpolation)
        super().__init__({
            "take": In(1),
            "samples": In(samples_layout(word_bytes, interpolation)),
            "x": In(ceil_log2(TILE_WIDTH)),
            "y": In(ceil_log2(interpolation.box_rows)),
            "o": Out(data.ArrayLayout(8, len(interpolation.samples))),
        } | {name: In(layout) for name, layout in layouts.items()}
            | ({"flip": In(1)} if layouts else {}))


class Align(_Align):
    __doc__ = _Align.__doc__ + """
    Windows without a margin: the first stage chooses rows, the second one bytes.
    """

    latency = 2

    def elaborate(self, platform):
        m = Module()
        window, rows = self.interpolation.window, self.interpolation.box_rows
        bytes_across = COLUMNS * self.word_bytes
        byte = delay(m, self.x[:ceil_log2(bytes_across)], 2, "byte")
        for j in range(window):
            which = register(m, f"which{j}", (self.y + j)[:ceil_log2(rows)])
            row = register(m, f"row{j}", Value.cast(self.samples[which]))
            # The second word is followed by the first one.
            around = Cat(row, row)
            with m.If(self.take):
                m.d.sync += Cat(*(self.o[window * j + k] for k in range(window))).eq(
                    Cat(around.word_select(byte + k, 8) for k in range(window)))
        return m


class AlignMirrored(_Align):
    __doc__ = _Align.__doc__ + """
    Windows with a margin, whose samples outside the frame are mirrored about its first or last
    column or row. Eight neighbouring columns, and rows, hold a window, so that of the two bytes, or
    four, whose columns are the same modulo 8, one is enough. A sample and its mirror image are an
    even number of positions apart. Once the positions have been rotated by the lowest bit of the
    window's first row, each row is one of four. The first stage chooses bytes and rotates the
    rows by one or not, the second one chooses rows; the third and the fourth do so with columns.
    Each stage chooses from at most four bits for each bit, or eight in the first one of four
    bytes: this fits a look-up table of common devices.
    """

    latency = 4

    def elaborate(self, platform):
        m = Module()
        needs = self.interpolation
        ring = needs.box_rows                   # columns that are chosen, as many as rows
        bits = ceil_log2(ring)

        staged = partial(register, m)
        # The first column and row of the window, their low bits.
        across = COLUMNS * self.word_bytes // ring      # rings side by side in the samples
        column, row = Signal(bits + ceil_log2(across)), Signal(bits)
        m.d.comb += [column.eq(self.x - needs.margin), row.eq(self.y - needs.margin)]
        # Stage 1: of both words, the columns from the window's first one on; rows by one or not.
        bytes_of = [[] for _ in self.samples]
        s_row = staged("s_row", row)
        for k in range(ring):
            # Ring that has the window's column k modulo 8.
            which = Signal(ceil_log2(across), name=f"which{k}", reset_less=True)
            m.d.sync += which.eq(column[bits:] + (column[:bits] > k if k < ring - 1 else 0))
            for j in range(ring):
                values = [chosen(list(samples)[k::ring], which)
                          for samples in (self.samples[j], self.samples[(j + 1) % ring])]
                bytes_of[j].append(staged(f"w_{j}{k}", chosen(values, s_row[:1])))
        w_rows = self._positions(m, "w_row", s_row, staged("s_edge_y", self.edge_y))
        w_column, w_edge = (delay(m, value, 2, name) for value, name in
                            ((column[:bits], "column"), (self.edge_x, "edge_x")))
        w_flip = delay(m, self.flip, 2, "flip")
        # Stage 2: the rows.
        rows = [staged(f"r_{j}", chosen([Cat(each) for each in bytes_of[j % 2::2]], position))
                for j, position in enumerate(w_rows)]
        r_column, r_edge = staged("r_column", w_column), staged("r_edge", w_edge)
        r_flip, by_one = staged("r_flip", w_flip), staged("by_one", w_column[:1] ^ w_flip)
        # Stage 3: columns by one or not, as the first one that is put out is even or odd.
        turned = []
        for j, value in enumerate(rows):
            samples = [value.word_select(k, 8) for k in range(ring)]
            turned.append([staged(f"c_{j}{k}", chosen(
                [samples[k], samples[(k + 1) % ring]], by_one)) for k in range(ring)])
        c_columns = self._positions(m, "c_column", r_column, r_edge, r_flip)
        # Stage 4: the columns.
        for k, (j, i) in enumerate(needs.samples):
            with m.If(self.take):
                m.d.sync += self.o[k].eq(chosen(turned[j][i % 2::2], c_columns[i]))
        return m

    def _positions(self, m, name, first, edge, flip=Const(0)):
        """For each column or row of the window, its position among four, a clock later.

        ``first``: where the window begins, modulo 8. ``flip``: whether they come in reverse.
        """
        found, last = [], self.interpolation.window - 1
        # In reverse, all of them have the other parity.
        begin = Signal(len(first) - 1, name=f"{name}_begin")
        m.d.comb += begin.eq((first + flip) >> 1)
        for k in range(last + 1):
            position = Signal(len(begin), name=f"{name}{k}_position")
            inside = Mux(flip, self._inside(last - k, edge)[1:] - k % 2,
                         self._inside(k, edge)[1:])
            m.d.comb += position.eq(begin + inside)
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
