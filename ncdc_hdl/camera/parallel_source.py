"""A parallel sensor's pins as a stream of samples."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.camera.layouts import PINS
from ncdc_hdl.camera.samples import samples
from ncdc_hdl.lib.pipeline import register

__all__ = ["ParallelSource"]


class ParallelSource(wiring.Component):
    """Gives each sample that comes while both valid signals are high.

    A frame under way at the end of a reset is ignored. A row ends where LINE_VALID or FRAME_VALID
    falls, a frame where FRAME_VALID does.

    Timing: free-running; a sample leaves ``latency`` clocks after it came.

    Members
    -------
    pins : ``In(PINS)``
    o : ``Out(samples(1))``
    """

    latency = 2

    def __init__(self):
        super().__init__({"pins": In(PINS), "o": Out(samples(1))})

    def elaborate(self, platform):
        m = Module()
        armed = Signal()        # FRAME_VALID has been low since the reset
        with m.If(~self.pins.frame_valid):
            m.d.sync += armed.eq(1)
        frame = register(m, "frame", self.pins.frame_valid, reset_less=False)
        line = register(m, "line", self.pins.frame_valid & self.pins.line_valid & armed,
                        reset_less=False)
        # A clock later it is known whether a sample was the last one.
        line_before = register(m, "line_before", line, reset_less=False)
        frame_before = register(m, "frame_before", frame, reset_less=False)
        fresh = Signal(init=1)  # the next sample is the first one of a frame
        with m.If(line_before):
            m.d.sync += fresh.eq(0)
        ends = frame_before & ~frame
        with m.If(ends):
            m.d.sync += fresh.eq(1)
        m.d.comb += [
            self.o.valid.eq(line_before),
            self.o.sample[0].eq(register(m, "sample_before", register(
                m, "sample", self.pins.data))),
            self.o.first.eq(line_before & fresh), self.o.last.eq(line_before & ~line),
            self.o.end.eq(ends & (line_before | ~fresh))]
        return m
