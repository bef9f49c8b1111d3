"""Cuts a window out of the samples that the tile memory gives."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.tiles import COLUMNS, samples_layout
from ncdc_model.fetch.cache_options import TILE_HEIGHT, TILE_WIDTH
from ncdc_model.geometry import WINDOW

__all__ = ["Align"]


class Align(wiring.Component):
    """Nine samples from (x, y) on, of samples that are placed by x and y modulo the box::

        o[3 j + i] = samples[(y + j) mod 4][(x + i) mod (2 word_bytes)]

    Timing: ``latency`` shifts; ``x`` and ``y`` belong to the samples of the same shift. The first
    stage chooses rows and words, the second one bytes.

    Members
    -------
    shift, take : ``In(1)``
        Whether the stages move; whether ``o`` takes on what leaves the first one.
    samples : ``In(samples_layout(word_bytes))``
    x, y : ``In(4)``, ``In(2)``
        In the tile.
    o : ``Out(ArrayLayout(8, 9))``
    """

    latency = 2

    def __init__(self, word_bytes):
        self.word_bytes = word_bytes
        super().__init__({
            "shift": In(1), "take": In(1), "samples": In(samples_layout(word_bytes)),
            "x": In(ceil_log2(TILE_WIDTH)), "y": In(ceil_log2(TILE_HEIGHT)),
            "o": Out(data.ArrayLayout(8, WINDOW * WINDOW)),
        })

    def elaborate(self, platform):
        m = Module()
        byte_bits = ceil_log2(self.word_bytes)
        kept = self.word_bytes + WINDOW - 1
        byte = Signal(byte_bits)
        with m.If(self.shift):
            m.d.sync += byte.eq(self.x)
        for j in range(WINDOW):
            row = Signal(8 * COLUMNS * self.word_bytes, name=f"row{j}")
            words = Signal(8 * kept, name=f"words{j}")
            m.d.comb += row.eq(Value.cast(self.samples[(self.y + j)[:2]]))
            with m.If(self.shift):
                m.d.sync += words.eq(Mux(self.x[byte_bits],
                                         row.rotate_right(8 * self.word_bytes), row))
            with m.If(self.shift & self.take):
                m.d.sync += Cat(*(self.o[WINDOW * j + k] for k in range(WINDOW))).eq(
                    words >> (byte << 3))
        return m
