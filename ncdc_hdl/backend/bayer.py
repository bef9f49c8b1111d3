"""Fast Bayer decoder: four colours from the four overlapping quads of a 3x3 raw window."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.lib.pipeline import register
from ncdc_spec.interpolation import FAST

__all__ = ["BayerQuads", "QUADS"]

# Quad (j, i), colours red, green, blue in units of a half: index 6 j + 3 i + colour.
QUADS = data.ArrayLayout(9, 12)


class BayerQuads(wiring.Component):
    """The colour of each quad of 2x2 samples: one red, one blue, the sum of two greens.

    All in units of a half (red and blue doubled), so that nothing is rounded here. Equal bit for
    bit to ``ncdc_model.golden.picture.bayer_quads``; section III.A and Fig. 12 of the paper.
    Timing: free-running, latency 2: samples are chosen, then greens added.

    Members
    -------
    samples : ``In(ArrayLayout(8, 9))``
        Row by row.
    red_column, red_row : ``In(1)``
        Whether the window's first sample is in a column, a row, that holds red samples.
    o : ``Out(QUADS)``
    """

    latency = 2

    def __init__(self):
        super().__init__({"samples": In(data.ArrayLayout(8, FAST.window * FAST.window)),
                          "red_column": In(1), "red_row": In(1), "o": Out(QUADS)})

    def elaborate(self, platform):
        m = Module()
        for j in range(2):
            for i in range(2):
                k = FAST.window * j + i
                a, b = self.samples[k], self.samples[k + 1]
                c, d = self.samples[k + FAST.window], self.samples[k + FAST.window + 1]
                # The next quad starts in a column, a row, of the other kind.
                red_column, red_row = self.red_column ^ i, self.red_row ^ j
                # Cycle 1: choose the quad's red, its blue and its two greens.
                chosen = {
                    "red": Mux(red_row, Mux(red_column, a, b), Mux(red_column, c, d)),
                    "blue": Mux(red_row, Mux(red_column, d, c), Mux(red_column, b, a)),
                    "green0": Mux(red_row == red_column, b, a),
                    "green1": Mux(red_row == red_column, c, d),
                }
                s0 = {name: register(m, f"s0_{name}_{j}{i}", value)
                      for name, value in chosen.items()}
                # Cycle 2: add the greens, double the others.
                n = 6 * j + 3 * i
                m.d.sync += [self.o[n].eq(s0["red"] << 1),
                             self.o[n + 1].eq(s0["green0"] + s0["green1"]),
                             self.o[n + 2].eq(s0["blue"] << 1)]
        return m
