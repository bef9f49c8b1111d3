"""Cuts a window out of the samples that the tile memory gives."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.tiles import COLUMNS, samples_layout
from ncdc_hdl.backend.layouts import edges
from ncdc_model.fetch.cache_options import TILE_WIDTH

__all__ = ["align_for"]


def align_for(word_bytes, interpolation):
    """What cuts the windows of ``interpolation`` out of words of ``word_bytes`` bytes."""
    return (AlignMirrored if interpolation.margin else Align)(word_bytes, interpolation)


class _Align(wiring.Component):
    """Samples of a window, of samples that are placed by x and y modulo the box::

        o[k] = samples[(y - margin + j) mod M][(x - margin + i) mod (2 word_bytes)]

    for each (j, i) of ``interpolation.samples``.

    Timing: ``latency`` shifts; ``x``, ``y`` and the edges belong to the samples of the same shift.

    Members
    -------
    shift, take : ``In(1)``
        Whether the stages move; whether ``o`` takes on what leaves the last but one.
    samples : ``In(samples_layout(word_bytes, interpolation))``
    x, y : ``In``
        Low bits of the sample that names the first place.
    edge_x, edge_y : ``In(edge_layout(interpolation))``
        Of windows with a margin.
    o : ``Out(ArrayLayout(8, n))``
    """

    def __init__(self, word_bytes, interpolation):
        self.word_bytes, self.interpolation = word_bytes, interpolation
        layouts = edges(interpolation)
        super().__init__({
            "shift": In(1), "take": In(1),
            "samples": In(samples_layout(word_bytes, interpolation)),
            "x": In(ceil_log2(max(TILE_WIDTH, COLUMNS * word_bytes))),
            "y": In(ceil_log2(interpolation.box_rows)),
            "o": Out(data.ArrayLayout(8, len(interpolation.samples))),
        } | {name: In(layout) for name, layout in layouts.items()})


class Align(_Align):
    __doc__ = _Align.__doc__ + """
    Windows without a margin: the first stage chooses rows, the second one bytes.
    """

    latency = 2

    def elaborate(self, platform):
        m = Module()
        window, rows = self.interpolation.window, self.interpolation.box_rows
        bytes_across = COLUMNS * self.word_bytes
        byte = Signal(range(bytes_across), reset_less=True)
        with m.If(self.shift):
            m.d.sync += byte.eq(self.x)
        for j in range(window):
            row = Signal(8 * bytes_across, name=f"row{j}", reset_less=True)
            with m.If(self.shift):
                m.d.sync += row.eq(Value.cast(self.samples[(self.y + j)[:ceil_log2(rows)]]))
            # The second word is followed by the first one.
            around = Cat(row, row)
            with m.If(self.shift & self.take):
                m.d.sync += Cat(*(self.o[window * j + k] for k in range(window))).eq(
                    Cat(around.word_select(byte + k, 8) for k in range(window)))
        return m


class AlignMirrored(_Align):
    __doc__ = _Align.__doc__ + """
    Windows with a margin, whose samples outside the frame are mirrored about its first or last
    column or row. Eight neighbouring columns hold a window, so that of the two bytes, or four,
    whose columns are the same modulo 8 one is enough: the first stage chooses it. The second one
    turns the rows, the third the columns, the fourth one mirrors.
    """

    latency = 4

    def elaborate(self, platform):
        m = Module()
        needs = self.interpolation
        margin, wanted = needs.margin, needs.samples
        ring = needs.box_rows                   # columns that stay, as many as rows
        bits = ceil_log2(ring)

        def register(name, value):
            """``value`` after the next shift."""
            r = Signal.like(value, name=name, reset_less=True)
            with m.If(self.shift):
                m.d.sync += r.eq(value)
            return r

        def turned(values, by):
            """``values``, a list of a power of two, with element ``by`` first."""
            for k, bit in enumerate(by):
                values = [Mux(bit, values[(n + (1 << k)) % len(values)], value)
                          for n, value in enumerate(values)]
            return values

        # The first column and row of the window, as far as they count.
        across = COLUMNS * self.word_bytes // ring      # rings side by side in the samples
        column, row = Signal(bits + ceil_log2(across)), Signal(bits)
        m.d.comb += [column.eq(self.x - margin), row.eq(self.y - margin)]
        # Stage 1: of both words, the columns from the window's first one on.
        chosen = [[] for _ in self.samples]
        for k in range(ring):
            # Which ring has the window's column that is k modulo 8.
            which = Signal(ceil_log2(across), name=f"which{k}")
            m.d.comb += which.eq(column[bits:] + (column[:bits] > k if k < ring - 1 else 0))
            for j, samples in enumerate(self.samples):
                chosen[j].append(register(f"w_{j}{k}", turned(list(samples)[k::ring], which)[0]))
        w_column, w_row = register("w_column", column[:bits]), register("w_row", row)
        # Stage 2: the rows.
        rows = [Cat(each) for each in chosen]
        rows = [register(f"r_{j}", value)
                for j, value in enumerate(turned(rows, w_row)[:needs.window])]
        r_column = register("r_column", w_column)
        # Stage 3: the columns.
        window = {}
        for j, value in enumerate(rows):
            for i, byte in enumerate(turned([value.word_select(k, 8) for k in range(ring)],
                                            r_column)):
                if (j, i) in wanted:
                    window[j, i] = register(f"c_{j}{i}", byte)
        edge_x, edge_y = self.edge_x, self.edge_y
        for n in range(3):
            edge_x, edge_y = register(f"edge_x{n}", edge_x), register(f"edge_y{n}", edge_y)
        # Stage 4: samples outside are those as far inside.
        for k, (j, i) in enumerate(wanted):
            value = self._inside(j, edge_y, lambda j, i=i: self._inside(
                i, edge_x, lambda i, j=j: window[j, i]))
            with m.If(self.shift & self.take):
                m.d.sync += self.o[k].eq(value)
        return m

    def _inside(self, k, edge, sample):
        """``sample(k)``, or if row or column k of the window is outside that as far inside."""
        margin, last = self.interpolation.margin, self.interpolation.window - 1
        value = sample(k)
        for missing in range(1, margin + 1):
            if k < missing:
                value = Mux((edge.missing == missing) & ~edge.behind, sample(2 * missing - k),
                            value)
            if last - k < missing:
                value = Mux((edge.missing == missing) & edge.behind,
                            sample(2 * (last - missing) - k), value)
        return value
