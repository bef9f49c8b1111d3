"""Counts through a video mode, pixel by pixel."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

__all__ = ["Beam"]


class Beam(wiring.Component):
    """Position of a screen's beam, in the domain ``pixel``.

    Timing: all outputs belong to the same pixel, and are combinational functions of the counters.

    Parameters
    ----------
    mode : ncdc_hdl.video.modes.VideoMode

    Members
    -------
    x, y : ``Out(range(pixels of a line))``, ``Out(range(lines of a frame))``
        From 0 on; the visible pixels come first.
    visible : ``Out(1)``
    hsync, vsync : ``Out(1)``
        As the mode's pulses are on the wire: high or low.
    below : ``Out(1)``
        High for one clock: the first pixel below the picture, where the vertical blanking begins.
    """

    def __init__(self, mode):
        self.mode = mode
        super().__init__({
            "x": Out(range(sum(mode.horizontal))), "y": Out(range(sum(mode.vertical))),
            "visible": Out(1), "hsync": Out(1), "vsync": Out(1), "below": Out(1)})

    def elaborate(self, platform):
        m = Module()
        mode, x, y = self.mode, self.x, self.y
        end_x, end_y = x == sum(mode.horizontal) - 1, y == sum(mode.vertical) - 1
        m.d.pixel += x.eq(Mux(end_x, 0, x + 1))
        with m.If(end_x):
            m.d.pixel += y.eq(Mux(end_y, 0, y + 1))
        width, height = mode.size
        m.d.comb += [
            self.visible.eq((x < width) & (y < height)),
            self.hsync.eq(self._pulse(x, mode.horizontal)),
            self.vsync.eq(self._pulse(y, mode.vertical)),
            self.below.eq((x == 0) & (y == height)),
        ]
        return m

    def _pulse(self, count, lengths):
        """Level of a sync signal; the pulse is after the front porch."""
        start = lengths[0] + lengths[1]
        return ((count >= start) & (count < start + lengths[2])) ^ (not self.mode.high)
