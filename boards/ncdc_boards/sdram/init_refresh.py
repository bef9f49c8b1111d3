"""Initialisation of the memory, and its refreshes."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["InitRefresh"]


class InitRefresh(wiring.Component):
    """Initialises the memory after a reset, then requests refreshes periodically.

    The initialisation: the chip's pause, all banks closed, its refreshes, its mode register. After
    it, another reset waits only for ``settle`` clocks instead of the pause: open rows must
    be closed soon, and refreshes must continue.

    Timing: ``due`` rises every ``period`` clocks, and stays until the refresh is given.

    Parameters
    ----------
    clocks : SdramTiming
    refreshes, period, settle : int
        Refreshes of the initialisation; clocks between two others; clocks after which any command
        is allowed after any other.

    Members
    -------
    due : ``Out(1)``
        No new read or write may begin; those under way continue.
    quiet : ``In(1)``
        No read or write is under way.
    precharge_all_allowed, idle : ``In(1)``
        As in :class:`Banks`.
    precharge_all, refresh, mode : ``Out(1)``
        This command is given in this clock.
    ready : ``Out(1)``
        The memory is initialised.
    """

    def __init__(self, clocks, *, refreshes, period, settle):
        self.clocks, self.refreshes, self.period = clocks, refreshes, period
        self.settle = settle
        super().__init__({
            "due": Out(1), "quiet": In(1), "precharge_all_allowed": In(1), "idle": In(1),
            "precharge_all": Out(1), "refresh": Out(1), "mode": Out(1), "ready": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        pause = self.clocks.pause
        timer = Signal(range(max(pause, self.period)), init=pause - 1)  # clocks left
        over = Signal()                         # the timer has expired
        more = Signal(range(self.refreshes + 1), init=self.refreshes)   # refreshes to give
        warm = Signal(reset_less=True)          # the memory has been initialised before
        settling = Signal(range(self.settle + 1), init=self.settle)     # clocks to wait if so
        m.d.sync += [over.eq(timer == 1), timer.eq(timer - 1), warm.eq(warm | self.ready)]
        with m.If(settling != 0):
            m.d.sync += settling.eq(settling - 1)
        with m.If(over):
            m.d.sync += timer.eq(self.period - 1)
        with m.FSM():
            with m.State("PAUSE"):
                m.d.comb += self.due.eq(1)
                with m.If(over | warm & (settling == 0)):
                    m.next = "PRECHARGE"
            with m.State("PRECHARGE"):
                m.d.comb += [self.due.eq(1),
                             self.precharge_all.eq(self.quiet & self.precharge_all_allowed)]
                with m.If(self.precharge_all):
                    m.next = "REFRESH"
            with m.State("REFRESH"):
                m.d.comb += [self.due.eq(1), self.refresh.eq(self.idle)]
                with m.If(self.idle):
                    m.d.sync += more.eq(more - 1)
                    with m.If(more == 1):
                        m.d.sync += more.eq(1)
                        m.next = "RUN"
                        with m.If(~self.ready):
                            m.next = "MODE"
            with m.State("MODE"):
                m.d.comb += [self.due.eq(1), self.mode.eq(self.idle)]
                with m.If(self.idle):
                    m.d.sync += [self.ready.eq(1), timer.eq(self.period - 1), over.eq(0)]
                    m.next = "RUN"
            with m.State("RUN"):
                with m.If(over):
                    m.next = "PRECHARGE"
        return m
