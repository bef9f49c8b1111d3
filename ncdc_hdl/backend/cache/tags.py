"""The tag stage: finds tiles, and claims the missing ones."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.act import Act
from ncdc_hdl.backend.cache.claims import Claims
from ncdc_hdl.backend.cache.clearing import Clearing
from ncdc_hdl.backend.cache.forwarding import Forwarding
from ncdc_hdl.backend.cache.interlock import Interlock
from ncdc_hdl.backend.cache.layouts import (
    lookup_layout,
    stalls_layout,
    tile_layout,
    tiles_of,
    window_position_layout,
)
from ncdc_hdl.backend.cache.pending import Pending
from ncdc_hdl.backend.cache.tag_memory import TagMemory

__all__ = ["Tags"]


class Tags(wiring.Component):
    """Looks tiles up, claims those that are missing, and passes the position on, in order.

    Banks of entries {valid, tag, last_use}, one entry per set. A look-up goes through five
    stages, which shift together:

    - R: its entries leave the memory; earlier look-ups with the same entries are found;
    - L: the entries move from the memory's registers, which may be far away, to those of the logic;
    - C: the entries are compared with its tiles;
    - D: missing tiles and busy entries are known;
    - A, act: the look-up is passed on and writes {1, its tags, its own sequence number} to every
      entry that it touched. After it its missing tiles are claimed, see ``Claims``, while others
      are passed on.

    In the act stage it waits for

    - interlock: the last user of a missing tile's entry, by its sequence number, has not read its
      samples yet;
    - credit: it misses tiles, and those of earlier look-ups are still to be claimed, as no more
      tiles may be requested;
    - pending: the limit of look-ups between here and the read of their samples is reached.

    After a frame's last look-up, and after reset, all entries are made invalid, a set per clock,
    and nothing is accepted meanwhile. They retain a last user, so that the interlock holds.

    Timing: ``latency`` clocks from a look-up to the act stage; one look-up per clock, as long as no
    more tiles are missing than clocks pass.

    Parameters
    ----------
    f_bits, options, lanes
        As in :class:`ncdc_hdl.backend.cache.cache.Cache`.

    Members
    -------
    i : ``In(stream.Signature(lookup_layout(...)))``
    claim, tile : ``Out(1)``, ``Out(tile_layout(options))``
        A tile is claimed in this clock.
    credit : ``In(1)``
        A tile may be claimed.
    push, position, missing : ``Out``
        A look-up is passed on, and its missing tiles. There is always space: see
        ``retire``.
    retire : ``In(1)``
        The oldest look-up passed on reads its samples in this clock.
    stalls : ``Out(stalls_layout())``
        Reason why the look-up in the act stage stays in this clock, if it does.
    """

    latency = 5
    """Clocks from a look-up's acceptance to the act stage, without stalls: R, L, C, D, A."""
    retire_to_push = Pending.latency
    """Clocks from ``retire`` to the space that it frees."""
    retire_to_replace = Pending.latency + Act.latency
    """Clocks from ``retire`` to the push of a look-up that replaces the tiles read."""
    push_to_claim = Claims.latency
    """Clocks from ``push`` to the first ``claim`` for that look-up."""

    def __init__(self, f_bits, options, lanes=1):
        self.f_bits, self.options, self.lanes = f_bits, options, lanes
        self.clearing = Clearing(options)
        self.forwarding = Forwarding(options)
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
            "position": Out(window_position_layout(f_bits, options, lanes)),
            "missing": Out(options.tag_banks),
            "retire": In(1),
            "stalls": Out(stalls_layout()),
        })

    def elaborate(self, platform):
        m = Module()
        for name in ("clearing", "forwarding", "memory", "pending", "interlock", "act", "claims"):
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
            self.i.ready.eq(act.leave & ~self.clearing.closed),
            enters.eq(self.i.valid & ~self.clearing.closed),
        ]
        stages = ((r_valid, r), (l_valid, l), (c_valid, c), (d_valid, d), (a_valid, a))
        with m.If(act.shift):
            for (valid, stage), (before_valid, before) in zip(
                    stages, ((enters, self.i.p), *stages)):
                # An empty stage must not need tiles, not even after a reset.
                m.d.sync += [valid.eq(before_valid), stage.eq(before),
                             stage.need.eq(Mux(before_valid, before.need, 0))]
        self._look_up(m, *(stage for _, stage in stages))
        m.d.comb += [self.forwarding.l_valid.eq(l_valid), self.forwarding.c_valid.eq(c_valid),
                     self.forwarding.d_valid.eq(d_valid), self.forwarding.a_valid.eq(a_valid)]

        # D: whether it may leave in the first clock of stage A.
        m.d.comb += [
            act.d_missing.eq(self.memory.missing),
            act.d_busy.eq(self.interlock.d_busy),
        ]

        # A: act.
        m.d.comb += [
            act.valid.eq(a_valid),
            act.busy.eq(self.interlock.a_busy),
            act.space.eq(self.pending.space),
            act.ready.eq(claims.i.ready),
            act.waiting.eq(claims.waiting),
            self.push.eq(act.push),
            self.position.eq(a.position),
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
        forwarding, memory = self.forwarding, self.memory
        interlock, pending = self.interlock, self.pending
        entering = tiles_of(self.options, self.i.p)
        in_r, in_l, in_c, in_d, in_a = (tiles_of(self.options, stage)
                                        for stage in (r, l, c, d, a))
        m.d.comb += [
            pending.push.eq(self.push),
            pending.retire.eq(self.retire),
            self.clearing.accepted.eq(self.i.valid & self.i.ready & self._last(self.i.p.position)),
            self.clearing.passed_on.eq(self.push & self._last(self.position)),
            # Into stage R: entries of the look-up that enters.
            forwarding.shift.eq(self.act.shift),
            forwarding.entering.eq(entering),
            forwarding.r.eq(in_r),
            forwarding.l.eq(in_l),
            forwarding.c.eq(in_c),
            forwarding.d.eq(in_d),
            forwarding.a.eq(in_a),
            memory.shift.eq(self.act.shift),
            memory.entering.eq(entering),
            # Out of stage C: the entries that have been read.
            memory.compared.eq(in_c),
            memory.known.eq(forwarding.known),
            memory.hit.eq(forwarding.hit),
            interlock.shift.eq(self.act.shift),
            interlock.touched.eq(forwarding.touched),
            interlock.between.eq(forwarding.between),
            interlock.last_use.eq(memory.last_use),
            interlock.more.eq(pending.more),
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
    def _last(position):
        """Whether a look-up is a frame's last.

        A method of its own only so that proofs and tests can take out the clearing.
        """
        return position.last
