"""The tag stage: which tiles are there, which are claimed, and when."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.act import Act
from ncdc_hdl.backend.cache.ahead import Ahead
from ncdc_hdl.backend.cache.clearing import Clearing
from ncdc_hdl.backend.cache.interlock import Interlock
from ncdc_hdl.backend.cache.layouts import (
    lookup_layout,
    row_bits,
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

    Banks of entries {valid, tag, last_use}, one entry per set. A look-up goes through four
    stages, which shift together:

    - R: its entries leave the memory; it learns which look-ups ahead touch the same ones;
    - C: the entries are compared with its tiles;
    - D: it is decided which tiles are missing, and which of their entries are busy;
    - A, act: missing tiles are claimed, one per clock by ascending bank; in the clock of the last
      claim, or at once if none is missing, the look-up is passed on and writes {1, its tags, its
      own sequence number} to every entry that it touched.

    In the act stage it waits for

    - interlock: the entry's last user, by its sequence number, has not read its samples yet;
    - credit: no more tiles may be asked for;
    - pending: as many look-ups as allowed are between here and the read of their samples.

    After a frame's last look-up, and after reset, all entries are made invalid, a set per clock,
    and nothing is accepted meanwhile; they keep a last user, so that the interlock holds.

    Timing: ``latency`` clocks from a look-up to the act stage; one look-up per clock, and one more
    clock for each missing tile beyond the first.

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
    push, place, misses : ``Out``
        A look-up is passed on, with the number of tiles it claimed. There is always room: see
        ``retire``.
    retire : ``In(1)``
        The oldest look-up passed on reads its samples in this clock.
    stalls : ``Out(stalls_layout())``
        Why the look-up in the act stage neither claims nor leaves in this clock, if so.
    """

    latency = 4
    """Clocks from a look-up's acceptance to the act stage, if nothing waits: R, C, D, A."""
    retire_to_push = Pending.latency
    """Clocks from ``retire`` to the room that it makes."""
    retire_to_claim = Pending.latency + Act.latency
    """Clocks from ``retire`` to a claim in the place of what was read."""

    def __init__(self, f_bits, options, lanes=1):
        self.f_bits, self.options, self.lanes = f_bits, options, lanes
        self.clearing = Clearing(options)
        self.ahead = Ahead(options)
        self.memory = TagMemory(options)
        self.pending = Pending(options)
        self.interlock = Interlock(options)
        self.act = Act(options.tag_banks)
        super().__init__({
            "i": In(stream.Signature(lookup_layout(f_bits, options, lanes))),
            "claim": Out(1),
            "tile": Out(tile_layout(options)),
            "credit": In(1),
            "push": Out(1),
            "place": Out(window_place_layout(f_bits, options, lanes)),
            "misses": Out(range(options.tag_banks + 1)),
            "retire": In(1),
            "stalls": Out(stalls_layout()),
        })

    def elaborate(self, platform):
        m = Module()
        for name in ("clearing", "ahead", "memory", "pending", "interlock", "act"):
            m.submodules[name] = getattr(self, name)
        act = self.act
        lookup = self.i.payload.shape()
        r_valid = Signal()                          # whether there is a look-up in stage R
        c_valid = Signal()                          # in stage C
        d_valid = Signal()                          # in stage D
        a_valid = Signal()                          # in stage A
        r = Signal(lookup, reset_less=True)         # the look-up in stage R, valid or not
        c = Signal(lookup, reset_less=True)         # in stage C
        d = Signal(lookup, reset_less=True)         # in stage D
        a = Signal(lookup, reset_less=True)         # in stage A
        enters = Signal()                           # a look-up enters stage R with the next shift
        m.d.comb += [
            self.i.ready.eq(act.shift & ~self.clearing.closed),
            enters.eq(self.i.valid & ~self.clearing.closed),
        ]
        with m.If(act.shift):
            m.d.sync += [
                r_valid.eq(enters), c_valid.eq(r_valid), d_valid.eq(c_valid), a_valid.eq(d_valid),
                r.eq(self.i.p), c.eq(r), d.eq(c), a.eq(d),
                # An empty stage must not look like a miss: its `need` is zero. Behind a reset the
                # stages empty while the first sets are cleared.
                r.need.eq(Mux(enters, self.i.p.need, 0)),
            ]
        self._look_up(m, r, c, d, a)
        m.d.comb += [self.ahead.r_valid.eq(r_valid), self.ahead.c_valid.eq(c_valid),
                     self.ahead.d_valid.eq(d_valid)]

        # D: a tile is missing if neither a look-up ahead nor the entry in the memory has it.
        m.d.comb += [
            act.d_valid.eq(d_valid),
            act.d_missing.eq(Cat(~Mux(known, hit, same) for known, hit, same in zip(
                self.ahead.known, self.ahead.hit, self.memory.same))),
            act.d_busy.eq(self.interlock.d_busy),
        ]

        # A: act.
        m.d.comb += [
            act.valid.eq(a_valid),
            act.busy.eq(self.interlock.a_busy),
            act.credit.eq(self.credit),
            act.room.eq(self.pending.room),
            self.claim.eq(act.claim),
            self.push.eq(act.push),
            self.place.eq(a.place),
            self.misses.eq(act.misses),
            self.stalls.eq(act.stalls),
        ]
        self._claimed_tile(m, a)
        return m

    def _look_up(self, m, r, c, d, a):
        """Connect the parts with the look-ups in the stages, and with each other."""
        ahead, memory, interlock, pending = self.ahead, self.memory, self.interlock, self.pending
        entering = tiles_of(self.options, self.i.p)
        in_r, in_c, in_d, in_a = (tiles_of(self.options, stage) for stage in (r, c, d, a))
        m.d.comb += [
            pending.push.eq(self.push),
            pending.retire.eq(self.retire),
            self.clearing.accepted.eq(self.i.valid & self.i.ready & self._last(self.i.p.place)),
            self.clearing.passed_on.eq(self.push & self._last(self.place)),
            # Into stage R: entries of the look-up that enters.
            ahead.shift.eq(self.act.shift),
            ahead.entering.eq(entering),
            ahead.r.eq(in_r),
            ahead.c.eq(in_c),
            ahead.d.eq(in_d),
            ahead.a.eq(in_a),
            memory.shift.eq(self.act.shift),
            memory.entering.eq(entering),
            # Out of stage C: the entries that have been read.
            memory.compared.eq(in_c),
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

    def _claimed_tile(self, m, a):
        """The tile of the bank that the look-up in stage A claims, and its slot."""
        bank = self.act.bank
        # The number of the bank's bit, of which that of the column is the lowest bit.
        px, *rows = (Cat(bit for k, bit in enumerate(bank) if k >> n & 1).any()
                     for n in range(1 + row_bits(self.options)))
        py = Cat(rows)
        chosen_set = Mux(px, a.set_x[1], a.set_x[0]) | _chosen(a.set_y, rows)
        m.d.comb += [
            self.tile.x.eq(Cat(px, Mux(px, a.pair_x[1], a.pair_x[0]))),
            self.tile.y.eq(Cat(py, _chosen(a.pair_y, rows))),
            self.tile.slot.eq(Cat(chosen_set, px, py)),
        ]

    @staticmethod
    def _last(place):
        """Whether a look-up is a frame's last.

        A method of its own only so that proofs and tests can take out the clearing.
        """
        return place.last


def _chosen(values, bits):
    """Element of ``values`` whose number has the binary digits ``bits``, the lowest one first."""
    values = list(values)
    for bit in bits:
        values = [Mux(bit, odd, even) for even, odd in zip(values[::2], values[1::2])]
    return values[0]
