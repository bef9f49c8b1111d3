"""The act stage: claims the tiles that a look-up misses, and passes it on."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import stalls_layout

__all__ = ["Act"]


class Act(wiring.Component):
    """Claims a look-up's missing tiles, one per clock by ascending bank, and lets it leave.

    A tile is claimed if its entry is not busy and there is credit. The look-up leaves in the clock
    of its last claim, or at once if none is missing, if there is room for it behind. Before each
    clock it is known what may happen in it, but for credit and room: the outputs are few gates
    behind registers.

    Timing: ``claim``, ``push`` and ``shift`` follow ``credit`` and ``room`` at once. A change of
    ``busy`` reaches ``claim`` after ``latency`` clocks.

    Parameters
    ----------
    banks : int
        Of tags.

    Members
    -------
    d_valid, d_missing, d_busy : ``In(1)``, ``In(banks)``, ``In(banks)``
        Of the look-up in stage D: whether there is one, which of its tiles are missing, and which
        of its entries are busy.
    valid, busy : ``In(1)``, ``In(banks)``
        Of the look-up in stage A: whether there is one, and which of its entries are busy.
    credit : ``In(1)``
        A tile may be claimed.
    room : ``In(1)``
        A look-up may be passed on.
    shift : ``Out(1)``
        All look-ups move on by one stage in this clock; the one in stage A, if any, leaves.
    claim, bank : ``Out(1)``, ``Out(banks)``
        The tile of the one bank whose bit is set is claimed in this clock.
    push, misses : ``Out(1)``, ``Out(range(banks + 1))``
        The look-up is passed on in this clock; the tiles claimed for it, this clock's included.
    stalls : ``Out(stalls_layout())``
        Why the look-up neither claims nor leaves in this clock, if so.
    """

    latency = 2
    """Clocks from a change of ``busy`` to the claim that it allows: a register, ``a_open``."""

    def __init__(self, banks):
        self.banks = banks
        super().__init__({
            "d_valid": In(1),
            "d_missing": In(banks),
            "d_busy": In(banks),
            "valid": In(1),
            "busy": In(banks),
            "credit": In(1),
            "room": In(1),
            "shift": Out(1),
            "claim": Out(1),
            "bank": Out(banks),
            "push": Out(1),
            "misses": Out(range(banks + 1)),
            "stalls": Out(stalls_layout()),
        })

    def elaborate(self, platform):
        m = Module()
        a_missing = Signal(self.banks)           # tiles that are still to be claimed
        a_busy = Signal(self.banks)              # `busy`, a clock ago
        a_misses = Signal.like(self.misses)     # tiles claimed in the clocks before
        a_hit = Signal(init=1)                  # no tile is missing, or there is no look-up
        a_open = Signal()                       # the lowest missing tile's entry is not busy
        a_final = Signal()                      # `a_open`, and no other tile is missing
        others = Signal(self.banks)              # the missing tiles but for the lowest one
        complete = Signal()                     # nothing is left to claim after this clock
        m.d.comb += [
            self.bank.eq(_lowest(a_missing)),
            others.eq(a_missing & ~self.bank),
            self.claim.eq(a_open & self.credit),
            complete.eq(a_hit | (a_final & self.credit)),
            self.shift.eq(complete & self.room),
            self.push.eq(self.valid & self.shift),
            self.misses.eq(a_misses + self.claim),
            self.stalls.interlock.eq(~a_hit & ~a_open),
            self.stalls.credit.eq(a_open & ~self.credit),
            self.stalls.pending.eq(self.valid & complete & ~self.room),
        ]

        outlook = Cat(a_hit, a_open, a_final)
        with m.If(self.shift):
            # Another look-up comes, or none, which misses nothing.
            hit, may_claim, final = _outlook(self.d_missing, self.d_busy)
            m.d.sync += [
                a_misses.eq(0),
                a_missing.eq(Mux(self.d_valid, self.d_missing, 0)),
                a_busy.eq(self.d_busy),
                a_hit.eq(~self.d_valid | hit),
                a_open.eq(self.d_valid & may_claim),
                a_final.eq(self.d_valid & final),
            ]
        with m.Else():
            m.d.sync += a_busy.eq(self.busy)
            with m.If(self.claim):
                m.d.sync += [a_missing.eq(others), a_misses.eq(a_misses + 1),
                             outlook.eq(Cat(_outlook(others, a_busy)))]
            with m.Else():
                m.d.sync += outlook.eq(Cat(_outlook(a_missing, a_busy)))
        return m


def _lowest(bits):
    """The lowest bit that is set, alone."""
    return Cat(bit & ~bits[:k].any() for k, bit in enumerate(bits))


def _outlook(missing, busy):
    """(No tile is missing; the lowest one may be claimed; it may, and no other one is missing.)"""
    lowest = _lowest(missing)
    may_claim = (lowest & ~busy).any()
    return ~missing.any(), may_claim, may_claim & ~(missing & ~lowest).any()
