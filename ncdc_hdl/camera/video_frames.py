"""Frames of a stream of video: the clocks between two, and one that begins too early."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.samples import FRAME_GAP

__all__ = ["VideoFrames"]


class VideoFrames(wiring.Component):
    """Follows which frame is under way, and keeps its clocks from the next one's.

    ``ready`` is low for FRAME_GAP clocks after a frame. A frame that begins before the end of
    another one waits: that one is ``short`` and ends first.

    Timing: all outputs belong to the clock of their inputs.

    Members
    -------
    valid, first, last : ``In(1)``
        Samples are offered; the first ones of a frame; the last ones.
    ready : ``Out(1)``
        They are taken.
    inside : ``Out(1)``
        They are taken, and belong to a frame.
    short : ``Out(1)``
        High for a clock: the frame under way is over without its last samples.
    """

    def __init__(self):
        super().__init__({"valid": In(1), "first": In(1), "last": In(1), "ready": Out(1, init=1),
                          "inside": Out(1), "short": Out(1)})

    def elaborate(self, platform):
        m = Module()
        under_way = Signal()
        gap = Signal(range(FRAME_GAP + 1))
        taken = self.valid & self.ready
        m.d.comb += [
            self.short.eq(self.valid & self.first & under_way),
            self.ready.eq((gap == 0) & ~self.short),
            self.inside.eq(taken & (self.first | under_way))]
        ends = self.inside & self.last | self.short
        with m.If(ends):
            m.d.sync += [under_way.eq(0), gap.eq(FRAME_GAP)]
        with m.Else():
            m.d.sync += gap.eq(Mux(gap == 0, 0, gap - 1))
            with m.If(self.inside):
                m.d.sync += under_way.eq(1)
        return m
