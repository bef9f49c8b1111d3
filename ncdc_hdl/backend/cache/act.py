"""The act stage: when a look-up may leave."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import stalls_layout

__all__ = ["Act"]


class Act(wiring.Component):
    """Lets a look-up leave if there is room for it behind, and if it misses tiles, only when none
    of their entries is busy and its claims are accepted.

    Before each clock it is known what may happen in it, but for ``ready`` and ``room``: the outputs
    are a gate behind registers.

    Timing: ``push`` and ``shift`` follow ``ready`` and ``room`` at once. A change of ``busy``
    reaches ``push`` after ``latency`` clocks.

    Parameters
    ----------
    banks : int
        Of tags.

    Members
    -------
    d_missing, d_busy : ``In(banks)``, ``In(banks)``
        Of the look-up in stage D: which of its tiles are missing, none if there is no look-up, and
        which of its entries are busy.
    valid, busy : ``In(1)``, ``In(banks)``
        Of the look-up in stage A: whether there is one, and which of its entries are busy.
    room : ``In(1)``
        A look-up may be passed on.
    shift : ``Out(1)``
        All look-ups move on by one stage in this clock; the one in stage A, if any, leaves.
    push : ``Out(1)``
        The look-up in stage A is passed on in this clock.
    missing : ``Out(banks)``
        Which of its tiles are missing.
    take, ready : ``Out(1)``, ``In(1)``
        It leaves in this clock, and some are missing, which are to be claimed; that is accepted.
    waiting : ``In(1)``
        Tiles wait to be claimed for want of credit.
    stalls : ``Out(stalls_layout())``
        Why the look-up in stage A does not leave in this clock, if so.
    """

    latency = 2
    """Clocks from a change of ``busy`` to the push that it allows: a register, ``a_clear``."""

    def __init__(self, banks):
        super().__init__({
            "d_missing": In(banks),
            "d_busy": In(banks),
            "valid": In(1),
            "busy": In(banks),
            "room": In(1),
            "shift": Out(1),
            "push": Out(1),
            "missing": Out(banks),
            "take": Out(1),
            "ready": In(1),
            "waiting": In(1),
            "stalls": Out(stalls_layout()),
        })

    def elaborate(self, platform):
        m = Module()
        a_busy = Signal.like(self.busy)         # `busy`, a clock ago
        a_hit = Signal(init=1)                  # no tile is missing, or there is no look-up
        a_clear = Signal(init=1)                # no entry of a missing tile is busy
        complete = Signal()                     # but for room, the look-up may leave
        m.d.comb += [
            complete.eq(a_hit | (a_clear & self.ready)),
            self.shift.eq(complete & self.room),
            self.push.eq(self.valid & self.shift),
            self.take.eq(~a_hit & self.shift),
            self.stalls.interlock.eq(~a_hit & ~a_clear),
            self.stalls.credit.eq(~a_hit & a_clear & ~self.ready & self.waiting),
            self.stalls.pending.eq(self.valid & complete & ~self.room),
        ]
        with m.If(self.shift):
            # Another look-up comes, or none, which misses nothing.
            m.d.sync += [self.missing.eq(self.d_missing), a_busy.eq(self.d_busy),
                         a_hit.eq(~self.d_missing.any()),
                         a_clear.eq(~(self.d_missing & self.d_busy).any())]
        with m.Else():
            m.d.sync += [a_busy.eq(self.busy), a_clear.eq(~(self.missing & a_busy).any())]
        return m
