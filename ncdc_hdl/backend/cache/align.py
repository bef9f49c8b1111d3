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
    stage chooses rows, the second one bytes.

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
        bytes_across = COLUMNS * self.word_bytes
        byte = Signal(range(bytes_across), reset_less=True)
        with m.If(self.shift):
            m.d.sync += byte.eq(self.x)
        for j in range(WINDOW):
            row = Signal(8 * bytes_across, name=f"row{j}", reset_less=True)
            with m.If(self.shift):
                m.d.sync += row.eq(Value.cast(self.samples[(self.y + j)[:2]]))
            # The second word is followed by the first one.
            around = Cat(row, row)
            with m.If(self.shift & self.take):
                m.d.sync += Cat(*(self.o[WINDOW * j + k] for k in range(WINDOW))).eq(
                    Cat(around.word_select(byte + k, 8) for k in range(WINDOW)))
        return m
