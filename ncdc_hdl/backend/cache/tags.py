"""The tag stage: which tiles are there, which are claimed, and when."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.act import Act
from ncdc_hdl.backend.cache.ahead import Ahead
from ncdc_hdl.backend.cache.claims import Claims
from ncdc_hdl.backend.cache.clearing import Clearing
from ncdc_hdl.backend.cache.interlock import Interlock
from ncdc_hdl.backend.cache.layouts import (
    lookup_layout,
    stalls_layout,
    tile_layout,
    tiles_of,
    window_place_layout,
)
from ncdc_hdl.backend.cache.pending import Pending
from ncdc_hdl.backend.cache.tag_memory import TagMemory

__all__ = ["Tags"]


class Tags(wiring.Component):
    """Looks tiles up, claims those that are missing, and passes the place on, in order.

    Banks of entries {valid, tag, last_use}, one entry per set. A look-up goes through five
    stages, which shift together:

    - R: its entries leave the memory; it learns which look-ups ahead touch the same ones;
    - L: the entries come from the memory's registers, which may be far off, to those of the logic;
    - C: the entries are compared with its tiles;
    - D: it is decided which tiles are missing, and which of their entries are busy;
    - A, act: the look-up is passed on and writes {1, its tags, its own sequence number} to every
      entry that it touched. Behind it its missing tiles are claimed, see ``Claims``, while others
      are passed on.

    In the act stage it waits for

    - interlock: the last user of a missing tile's entry, by its sequence number, has not read its
      samples yet;
    - credit: it misses tiles, and those of look-ups before it are still to be claimed, as no more
      tiles may be asked for;
    - pending: as many look-ups as allowed are between here and the read of their samples.

    After a frame's last look-up, and after reset, all entries are made invalid, a set per clock,
    and nothing is accepted meanwhile; they keep a last user, so that the interlock holds.

    Timing: ``latency`` clocks from a look-up to the act stage; one look-up per clock, as long as no
    more tiles are missing than clocks go by.

    Parameters
    ----------
    f_bits, options, lanes
        As of :class:`ncdc_hdl.backend.cache.cache.Cache`.

    Members
    -------
    i : ``In(stream.Signature(lookup_layout(...)))``
    claim, tile : ``Out(1)``, ``Out(tile_layout(options))``
        A tile is claimed in this clock.
    credit : ``In(1)``
        A tile may be claimed.
    push, place, missing : ``Out``
        A look-up is passed on, and which of its tiles are missing. There is always room: see
        ``retire``.
    retire : ``In(1)``
        The oldest look-up passed on reads its samples in this clock.
    stalls : ``Out(stalls_layout())``
        Why the look-up in the act stage does not leave in this clock, if so.
    """

    latency = 5
    """Clocks from a look-up's acceptance to the act stage, if nothing waits: R, L, C, D, A."""
    retire_to_push = Pending.latency
    """Clocks from ``retire`` to the room that it makes."""
    retire_to_replace = Pending.latency + Act.latency
    """Clocks from ``retire`` to the push of a look-up that replaces what was read."""
    push_to_claim = Claims.latency
    """Clocks from ``push`` to the first ``claim`` for that look-up."""

    def __init__(self, f_bits, options, lanes=1):
        self.f_bits, self.options, self.lanes = f_bits, options, lanes
        self.clearing = Clearing(options)
        self.ahead = Ahead(options)
        self.memory = TagMemory(options)
        self.pending = Pending(options)
        self.interlock = Interlock(options)
        self.act = Act(options.tag_banks)
        self.claims = Claims(options)
        super().__init__({
            "i": In(stream.Signature(lookup_layout(f_bits, options, lanes))),
            "claim": Out(1),
            "tile": Out(tile_layout(options)),
            "credit": In(1),
            "push": Out(1),
            "place": Out(window_place_layout(f_bits, options, lanes)),
            "missing": Out(options.tag_banks),
            "retire": In(1),
            "stalls": Out(stalls_layout()),
        })

    def elaborate(self, platform):
        m = Module()
        for name in ("clearing", "ahead", "memory", "pending", "interlock", "act", "claims"):
            m.submodules[name] = getattr(self, name)
        act, claims = self.act, self.claims
        lookup = self.i.payload.shape()
        r_valid = Signal()                          # whether there is a look-up in stage R
        l_valid = Signal()                          # in stage L
        c_valid = Signal()                          # in stage C
        d_valid = Signal()                          # in stage D
        a_valid = Signal()                          # in stage A
        r = Signal(lookup, reset_less=True)         # the look-up in stage R, valid or not
        l = Signal(lookup, reset_less=True)         # in stage L
        c = Signal(lookup, reset_less=True)         # in stage C
        d = Signal(lookup, reset_less=True)         # in stage D
        a = Signal(lookup, reset_less=True)         # in stage A
        enters = Signal()                           # a look-up enters stage R with the next shift
        m.d.comb += [
            self.i.ready.eq(act.shift & ~self.clearing.closed),
            enters.eq(self.i.valid & ~self.clearing.closed),
        ]
        stages = ((r_valid, r), (l_valid, l), (c_valid, c), (d_valid, d), (a_valid, a))
        with m.If(act.shift):
            for (valid, stage), (before_valid, before) in zip(
                    stages, ((enters, self.i.p), *stages)):
                # An empty stage must not look like one that needs tiles, not even behind a reset.
                m.d.sync += [valid.eq(before_valid), stage.eq(before),
                             stage.need.eq(Mux(before_valid, before.need, 0))]
        self._look_up(m, *(stage for _, stage in stages))
        m.d.comb += [self.ahead.r_valid.eq(r_valid), self.ahead.l_valid.eq(l_valid),
                     self.ahead.c_valid.eq(c_valid), self.ahead.d_valid.eq(d_valid)]

        # D: what may be done in the first clock of stage A.
        m.d.comb += [
            act.d_missing.eq(self.memory.missing),
            act.d_busy.eq(self.interlock.d_busy),
        ]

        # A: act.
        m.d.comb += [
            act.valid.eq(a_valid),
            act.busy.eq(self.interlock.a_busy),
            act.room.eq(self.pending.room),
            act.ready.eq(claims.i.ready),
            act.waiting.eq(claims.waiting),
            self.push.eq(act.push),
            self.place.eq(a.place),
            self.missing.eq(act.missing),
            self.stalls.eq(act.stalls),
            claims.i.valid.eq(act.take),
            claims.i.payload.eq(tiles_of(self.options, a)),
            claims.i.payload.need.eq(act.missing),
            claims.credit.eq(self.credit),
            self.claim.eq(claims.claim),
            self.tile.eq(claims.tile),
        ]
        return m

    def _look_up(self, m, r, l, c, d, a):
        """Connect the parts with the look-ups in the stages, and with each other."""
        ahead, memory, interlock, pending = self.ahead, self.memory, self.interlock, self.pending
        entering = tiles_of(self.options, self.i.p)
        in_r, in_l, in_c, in_d, in_a = (tiles_of(self.options, stage)
                                        for stage in (r, l, c, d, a))
        m.d.comb += [
            pending.push.eq(self.push),
            pending.retire.eq(self.retire),
            self.clearing.accepted.eq(self.i.valid & self.i.ready & self._last(self.i.p.place)),
            self.clearing.passed_on.eq(self.push & self._last(self.place)),
            # Into stage R: entries of the look-up that enters.
            ahead.shift.eq(self.act.shift),
            ahead.entering.eq(entering),
            ahead.r.eq(in_r),
            ahead.l.eq(in_l),
            ahead.c.eq(in_c),
            ahead.d.eq(in_d),
            ahead.a.eq(in_a),
            memory.shift.eq(self.act.shift),
            memory.entering.eq(entering),
            # Out of stage C: the entries that have been read.
            memory.compared.eq(in_c),
            memory.known.eq(ahead.known),
            memory.hit.eq(ahead.hit),
            interlock.shift.eq(self.act.shift),
            interlock.touched.eq(ahead.touched),
            interlock.between.eq(ahead.between),
            interlock.last_use.eq(memory.last_use),
            interlock.number.eq(pending.number),
            interlock.retired.eq(pending.retired),
            interlock.wrapped.eq(pending.wrapped),
            # Out of stage A: entries are written, or cleared.
            memory.leaving.eq(in_a),
            memory.number.eq(pending.number),
            memory.push.eq(self.push),
            memory.clearing.eq(self.clearing.clearing),
            memory.clear_set.eq(self.clearing.set),
        ]

    @staticmethod
    def _last(place):
        """Whether a look-up is a frame's last.

        A method of its own only so that proofs and tests can take out the clearing.
        """
        return place.last
