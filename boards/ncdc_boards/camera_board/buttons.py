"""Buttons that choose a lens, or the raw picture."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Chooser"]

_SAMPLES_HZ = 100       # a button that bounces for less than 10 ms counts once


class Chooser(wiring.Component):
    """From buttons to the number of the program that loads what they choose.

    Program 0 configures the board, program k loads the lens k - 1, the last one shows the raw
    picture. A press of ``following`` or ``previous`` goes to another lens; the first one is
    after the last. A press of ``raw`` shows the raw picture; the next press shows the lens again.

    Parameters
    ----------
    lenses : int
        Number of lenses, without the raw picture; at least 1.
    clock_hz : int

    Members
    -------
    following, previous, raw : ``In(1)``
        Buttons, high while pressed, synchronised to this domain.
    busy : ``In(1)``
        A program runs; a choice made meanwhile starts when it ends.
    start, which : ``Out(1)``, ``Out(range(lenses + 2))``
    lens : ``Out(range(lenses))``
        The chosen lens.
    """

    def __init__(self, lenses, clock_hz):
        self.lenses, self.clock_hz = lenses, clock_hz
        super().__init__({
            "following": In(1), "previous": In(1), "raw": In(1), "busy": In(1), "start": Out(1),
            "which": Out(range(lenses + 2)), "lens": Out(range(lenses + 1))})

    def elaborate(self, platform):
        m = Module()
        period = max(2, self.clock_hz // _SAMPLES_HZ)
        clock = Signal(range(period))
        look = Signal()
        m.d.comb += look.eq(clock == 0)
        m.d.sync += clock.eq(Mux(look, period - 1, clock - 1))
        now, before = Cat(self.following, self.previous, self.raw), Signal(3)
        pressed = Signal(3)
        m.d.comb += pressed.eq(now & ~before & look.replicate(3))
        with m.If(look):
            m.d.sync += before.eq(now)
        shows_raw = Signal()
        changed = Signal()              # the choice has not been started
        m.d.comb += [self.start.eq(changed & ~self.busy),
                     self.which.eq(Mux(shows_raw, self.lenses + 1, self.lens + 1))]
        with m.If(self.start):
            m.d.sync += changed.eq(0)
        with m.If(pressed.any()):
            m.d.sync += [changed.eq(1), shows_raw.eq(shows_raw ^ pressed[2])]
        with m.If(pressed[0]):
            m.d.sync += self.lens.eq(Mux(self.lens == self.lenses - 1, 0, self.lens + 1))
        with m.Elif(pressed[1]):
            m.d.sync += self.lens.eq(Mux(self.lens == 0, self.lenses - 1, self.lens - 1))
        return m
