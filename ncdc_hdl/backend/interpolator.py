"""From raw windows to corrected pixels."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.bayer import BayerQuads
from ncdc_hdl.backend.bilinear import Bilinear
from ncdc_hdl.backend.layouts import pixel_layout, window_layout
from ncdc_hdl.pipeline import delay
from ncdc_hdl.streams import CreditQueue

__all__ = ["Interpolator"]


class Interpolator(wiring.Component):
    """Bayer decoder and bilinear interpolator between two streams; blank pixels get the fill.

    The arithmetic runs free; a window is taken only if the queue behind has room for its pixel.
    Timing: one pixel per clock; ``latency`` clocks from a window to its pixel in the queue.

    Parameters
    ----------
    f_bits : int
        Fraction bits of the place in the window.

    Members
    -------
    phase, fill : ``In(2)``, ``In(24)``
        (column, row) parity of the red samples; colour of blank pixels, red in the top byte.
        Constant during a frame.
    i : ``In(stream.Signature(window_layout(f_bits)))``
    o : ``Out(stream.Signature(pixel_layout()))``
    """

    def __init__(self, f_bits):
        self.f_bits = f_bits
        self.bayer, self.bilinear = BayerQuads(), Bilinear(f_bits)
        super().__init__({
            "phase": In(2), "fill": In(24),
            "i": In(stream.Signature(window_layout(f_bits))),
            "o": Out(stream.Signature(pixel_layout())),
        })

    @property
    def latency(self):
        """Clocks from a window to its pixel in the queue."""
        return self.bayer.latency + self.bilinear.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.bayer, m.submodules.bilinear = bayer, bilinear = self.bayer, self.bilinear
        m.submodules.queue = queue = CreditQueue(pixel_layout(), depth=32, restart=31)
        window = self.i.p
        m.d.comb += [
            self.i.ready.eq(queue.room), queue.issue.eq(self.i.valid & self.i.ready),
            bayer.samples.eq(window.samples),
            bayer.red_column.eq(~(window.odd_column ^ self.phase[0])),
            bayer.red_row.eq(~(window.odd_row ^ self.phase[1])),
            bilinear.i.eq(bayer.o),
            bilinear.fx.eq(delay(m, window.fx, bayer.latency, "fx")),
            bilinear.fy.eq(delay(m, window.fy, bayer.latency, "fy")),
        ]
        flags = delay(m, Cat(window.first, window.last, window.blank), self.latency, "flags")
        m.d.comb += [
            queue.arrive.eq(delay(m, queue.issue, self.latency, "issue", reset_less=False)),
            Cat(queue.i.first, queue.i.last).eq(flags[:2]),
            Cat(queue.i.b, queue.i.g, queue.i.r).eq(
                Mux(flags[2], self.fill, Cat(bilinear.o[2], bilinear.o[1], bilinear.o[0]))),
        ]
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        return m
