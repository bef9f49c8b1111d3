"""Of the columns that the tile memory outputs, those of the box."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.tiles import samples_layout
from ncdc_hdl.lib.pipeline import register
from ncdc_spec.cache_options import BOX_COLUMNS, TILE_WIDTH

__all__ = ["Narrow"]


class Narrow(wiring.Component):
    """The 16 columns from the first one of a box on, of two words of 16 samples.

    A box is 16 columns wide at most. So of the two columns that are the same modulo 16 one is
    enough, and the windows of four lanes are cut out of half as many samples.

    Timing: ``latency`` clocks from the samples to ``o``; ``odd_tile`` and ``column`` come a clock
    before the samples.

    Parameters
    ----------
    interpolation : Interpolation

    Members
    -------
    odd_tile, column : ``In(1)``, ``In(range(16))``
        Of the tile in which the box begins, its column modulo 2; the column in it.
    samples : ``In(samples_layout(16, interpolation))``
    o : ``Out(samples_layout(8, interpolation))``
        Byte k of a row is the sample whose x is k modulo 16.
    """

    latency = 1

    def __init__(self, interpolation):
        self.interpolation = interpolation
        super().__init__({
            "odd_tile": In(1), "column": In(range(TILE_WIDTH)),
            "samples": In(samples_layout(TILE_WIDTH, interpolation)),
            "o": Out(samples_layout(BOX_COLUMNS // 2, interpolation))})

    def elaborate(self, platform):
        m = Module()
        for k in range(BOX_COLUMNS):
            # Columns before the box's first one are those of the next tile.
            before = self.column > k if k < BOX_COLUMNS - 1 else Const(0)
            second = register(m, f"second{k}", self.odd_tile ^ before)
            m.d.sync += [out[k].eq(Mux(second, row[k + TILE_WIDTH], row[k]))
                         for out, row in zip(self.o, self.samples)]
        return m
