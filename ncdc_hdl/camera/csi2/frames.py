"""Frames: their starts, their ends and what is wrong with them."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Frames"]


class Frames(wiring.Component):
    """Follows which frame is under way, and whether it is bad.

    A start within a frame ends it as bad, and begins another one. A frame without a sample is
    a fault and has no ``end``.

    Timing: ``end`` and ``bad`` follow one clock after ``ends`` or ``begins``.

    Members
    -------
    begins, ends : ``In(1)``
        Packets that start and end a frame.
    samples : ``In(1)``
        Samples leave.
    fault : ``In(1)``
        The frame under way is bad.
    open : ``Out(1)``
        A frame is under way.
    first : ``Out(1)``
        The next samples are the first ones of the frame.
    end, bad : ``Out(1)``
        High for a clock: the frame has ended; it was bad.
    order : ``Out(1)``
        High for a clock: a start in a frame, an end without one, a frame without a sample.
    """

    def __init__(self):
        super().__init__({
            "begins": In(1), "ends": In(1), "samples": In(1), "fault": In(1), "open": Out(1),
            "first": Out(1), "end": Out(1), "bad": Out(1), "order": Out(1)})

    def elaborate(self, platform):
        m = Module()
        faulty = Signal()       # a fault was found in the frame
        over = Signal()         # a frame with samples is over
        m.d.comb += [
            over.eq((self.begins | self.ends) & self.open & ~self.first),
            self.order.eq(Mux(self.begins, self.open, self.ends & (~self.open | self.first)))]
        m.d.sync += [self.end.eq(over), self.bad.eq(faulty | self.fault | self.begins)]
        with m.If(self.begins):
            m.d.sync += [self.open.eq(1), self.first.eq(1), faulty.eq(0)]
        with m.Elif(self.ends):
            m.d.sync += self.open.eq(0)
        with m.Else():
            with m.If(self.fault):
                m.d.sync += faulty.eq(1)
            with m.If(self.samples):
                m.d.sync += self.first.eq(0)
        return m
