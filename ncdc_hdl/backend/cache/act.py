"""The act stage, which decides when a look-up may leave."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import stalls_layout

__all__ = ["Act"]


class Act(wiring.Component):
    """Lets a look-up leave if there is space after it. With missing tiles it leaves only when none
    of their entries is busy and its claims are accepted.

    All but ``ready`` and ``space`` is known before each clock: the outputs
    are one gate after registers.

    Timing: ``push``, ``leave`` and ``shift`` follow ``ready`` and ``space`` at once. A change of
    ``busy`` reaches ``push`` after ``latency`` clocks.

    Parameters
    ----------
    banks : int
        Number of tag banks.

    Members
    -------
    d_missing, d_busy : ``In(banks)``, ``In(banks)``
        For the look-up in stage D: its missing tiles, none if there is no look-up, and
        its busy entries.
    valid, busy : ``In(1)``, ``In(banks)``
        For stage A: whether there is a look-up, and its busy entries.
    space : ``In(1)``
        A look-up may be passed on.
    shift : ``Out(1)``
        All look-ups move on by one stage in this clock; the one in stage A, if any, leaves.
    leave : ``Out(1)``
        Equal to ``shift``, by registers of its own: ``shift`` moves a few thousand flip-flops, and
        this is for all else.
    push : ``Out(1)``
        The look-up in stage A is passed on in this clock.
    missing : ``Out(banks)``
        Which of its tiles are missing.
    take, ready : ``Out(1)``, ``In(1)``
        It leaves in this clock with missing tiles, which are to be claimed; that is accepted.
    waiting : ``In(1)``
        Tiles wait to be claimed for credit.
    stalls : ``Out(stalls_layout())``
        Reason why the look-up in stage A stays in this clock, if it does.
    """

    latency = 2
    """Clocks from a change of ``busy`` to the push that it allows: a register, ``a_clear``."""

    def __init__(self, banks):
        super().__init__({
            "d_missing": In(banks),
            "d_busy": In(banks),
            "valid": In(1),
            "busy": In(banks),
            "space": In(1),
            "shift": Out(1),
            "leave": Out(1),
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
        a_misses = Signal()                     # the complement, which synthesis does not merge
        a_clear = Signal(init=1)                # no entry of a missing tile is busy
        complete = Signal()                     # the look-up may leave if there is space
        m.d.comb += [
            complete.eq(~a_misses | (a_clear & self.ready)),
            self.shift.eq((a_hit | (a_clear & self.ready)) & self.space),
            self.leave.eq(complete & self.space),
            self.push.eq(self.valid & self.leave),
            self.take.eq(a_misses & self.leave),
            self.stalls.interlock.eq(a_misses & ~a_clear),
            self.stalls.credit.eq(a_misses & a_clear & ~self.ready & self.waiting),
            self.stalls.pending.eq(self.valid & complete & ~self.space),
        ]
        with m.If(self.leave):
            # Another look-up comes, or none, which misses nothing.
            m.d.sync += [self.missing.eq(self.d_missing), a_busy.eq(self.d_busy),
                         a_hit.eq(~self.d_missing.any()), a_misses.eq(self.d_missing.any()),
                         a_clear.eq(~(self.d_missing & self.d_busy).any())]
        with m.Else():
            m.d.sync += [a_busy.eq(self.busy), a_clear.eq(~(self.missing & a_busy).any())]
        return m
