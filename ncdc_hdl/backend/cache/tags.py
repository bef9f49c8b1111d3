"""The tag stage: which tiles are there, which are claimed, and when."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import (
    PAIR_X_BITS,
    PAIR_Y_BITS,
    lookup_layout,
    set_bits,
    stalls_layout,
    tile_layout,
    window_place_layout,
)
from ncdc_hdl.lib.memory import block_memory
from ncdc_model.fetch.cache_options import TAG_BANKS

__all__ = ["Tags"]


class Tags(wiring.Component):
    """Looks tiles up, claims those that are missing, and passes the place on, in order.

    Four banks of entries {valid, tag, last_use}, one entry per set. A look-up in the act stage
    claims its missing tiles, one per clock by ascending bank; in the clock of its last claim, or
    at once if none is missing, it is passed on and writes {1, its tags, its own sequence number}
    to every entry that it touched. It waits for

    - interlock: the entry's last user, by its sequence number, has not read its samples yet;
    - credit: no more tiles may be asked for;
    - pending: as many look-ups as allowed are between here and the read of their samples.

    Entries are read three shifts before the act stage; what is passed on in between is forwarded.
    After a frame's last look-up, and after reset, all entries are made invalid, a set per clock,
    and nothing is accepted meanwhile; they keep a last user, so that the interlock holds.

    Timing: four stages that shift together; one look-up per clock, and one more clock for each
    missing tile beyond the first.

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
    retire_to_push = 1
    """Clocks from ``retire`` to the room that it makes: the level's register."""
    retire_to_claim = 3
    """Clocks from ``retire`` to a claim in its place: the number, ``a_busy``, ``a_open``."""

    def __init__(self, f_bits, options, lanes=1):
        self.options = options
        self.f_bits, self.lanes = f_bits, lanes
        super().__init__({
            "i": In(stream.Signature(lookup_layout(f_bits, options, lanes))),
            "claim": Out(1), "tile": Out(tile_layout(options)), "credit": In(1),
            "push": Out(1), "place": Out(window_place_layout(f_bits, options, lanes)),
            "misses": Out(range(TAG_BANKS + 1)),
            "retire": In(1),
            "stalls": Out(stalls_layout()),
        })

    def elaborate(self, platform):
        m = Module()
        options, lookup = self.options, self.i.payload.shape()
        sequence = options.sequence_bits
        entry = data.StructLayout({"valid": 1, "pair_x": PAIR_X_BITS, "pair_y": PAIR_Y_BITS,
                                   "last_use": sequence})
        # Numbers of the look-up in the act stage, and of the oldest that still has to read; a bit
        # more than entries have tells whether they are on the same side of the turn to 0.
        numbers, retirals = (Signal(sequence + 1, name=name) for name in ("numbers", "retirals"))
        number, retired = numbers[:sequence], retirals[:sequence]
        wrapped = numbers[-1] != retirals[-1]
        level = Signal(range(options.pending + 1))      # look-ups between the two
        room = Signal(init=1)                           # level != options.pending
        advance = Signal()
        with m.If(self.push):
            m.d.sync += numbers.eq(numbers + 1)
        with m.If(self.retire):
            m.d.sync += retirals.eq(retirals + 1)
        with m.If(self.push != self.retire):
            m.d.sync += [level.eq(Mux(self.push, level + 1, level - 1)),
                         room.eq(self.retire | (level != options.pending - 1))]

        # R: entries leave the memory. C: they are compared. D: which are missing. A: act.
        r_valid, c_valid, d_valid, a_valid = (Signal(name=f"{name}_valid") for name in "rcda")
        r, c, d, a = (Signal(lookup, reset_less=True, name=name) for name in "rcda")
        # Of look-ups ahead, nearest first: which entries they touch, whether with the same tile,
        # and how many look-ups are between.
        r_ahead = Signal(data.ArrayLayout(data.StructLayout(
            {"touches": TAG_BANKS, "present": TAG_BANKS, "between": range(4)}), 4),
            reset_less=True)
        # Together; known: what is not needed is not missing.
        c_touched, c_known, c_hit, d_touched, d_known, d_hit = (
            Signal(TAG_BANKS, name=f"{name}_{what}") for name in "cd"
            for what in ("touched", "known", "hit"))
        c_entry = Signal(data.ArrayLayout(entry, TAG_BANKS), reset_less=True)
        # Thirds of the comparison with the tile in the entry.
        d_same = Signal(data.ArrayLayout(3, TAG_BANKS))
        d_since = Signal(TAG_BANKS)
        d_before = Signal(TAG_BANKS)
        d_wrapped = Signal()
        between = Signal(range(4)).shape()
        c_between, d_between, a_between = (Signal(data.ArrayLayout(between, TAG_BANKS),
                                                  name=f"{name}_between") for name in "cda")
        d_last_use = Signal(data.ArrayLayout(sequence, TAG_BANKS), reset_less=True)
        a_misses = Signal.like(self.misses)

        closed, clearing, clear_set = self._clear(m)
        entering = Signal()
        m.d.comb += [self.i.ready.eq(advance & ~closed), entering.eq(self.i.valid & ~closed)]
        with m.If(advance):
            m.d.sync += [
                r_valid.eq(entering), c_valid.eq(r_valid), d_valid.eq(c_valid),
                a_valid.eq(d_valid), r.eq(self.i.p), c.eq(r), d.eq(c), a.eq(d),
                # Who is not there needs nothing. Behind a reset the stages empty while the first
                # sets are cleared.
                r.need.eq(Mux(entering, self.i.p.need, 0)),
                *(relation.between.eq(sum(ahead, start=Const(0)))
                  for relation, ahead in zip(r_ahead, ([], [r_valid], [r_valid, c_valid],
                                                       [r_valid, c_valid, d_valid]))),
                d_between.eq(c_between), a_between.eq(d_between),
                d_touched.eq(c_touched), d_known.eq(c_known), d_hit.eq(c_hit),
                d_wrapped.eq(wrapped),
            ]
            for bank in range(TAG_BANKS):
                for relation, other in zip(r_ahead, (r, c, d, a)):
                    px, py = bank & 1, bank >> 1
                    m.d.sync += [
                        relation.touches[bank].eq(other.need[bank]
                                                  & (self.i.p.set_x[px] == other.set_x[px])
                                                  & (self.i.p.set_y[py] == other.set_y[py])),
                        relation.present[bank].eq((self.i.p.pair_x[px] == other.pair_x[px])
                                                  & (self.i.p.pair_y[py] == other.pair_y[py])),
                    ]
                touched, present, nearest = Const(0, 1), Const(0, 1), Const(0, 2)
                for relation in reversed(list(r_ahead)):
                    touched = touched | relation.touches[bank]
                    present = Mux(relation.touches[bank], relation.present[bank], present)
                    nearest = Mux(relation.touches[bank], relation.between, nearest)
                m.d.sync += [c_between[bank].eq(nearest),
                             c_touched[bank].eq(touched), c_known[bank].eq(~r.need[bank] | touched),
                             c_hit[bank].eq(~r.need[bank] | present)]

        written = Signal(sequence)                      # the last look-up passed on
        with m.If(self.push):
            m.d.sync += written.eq(number)
        for bank in range(TAG_BANKS):
            px, py = bank & 1, bank >> 1
            # What is read in the clock of its write is known from the look-up ahead.
            m.submodules[f"entries{bank}"] = memory = block_memory(entry, options.sets)
            read, write = memory.read_port(), memory.write_port()
            m.d.comb += [
                read.addr.eq(self.i.p.set_x[px] | self.i.p.set_y[py]), read.en.eq(advance),
                write.en.eq(clearing | (advance & a.need[bank])),
                write.addr.eq(Mux(clearing, clear_set, a.set_x[px] | a.set_y[py])),
                write.data.valid.eq(~clearing),
                write.data.pair_x.eq(a.pair_x[px]), write.data.pair_y.eq(a.pair_y[py]),
                write.data.last_use.eq(Mux(clearing, written, number)),
            ]
            found = c_entry[bank]
            with m.If(advance):
                m.d.sync += [
                    c_entry[bank].eq(read.data),
                    d_same[bank].eq(Cat(held == sought for held, sought in zip(
                        self._thirds(Cat(found.pair_x, found.pair_y, found.valid)),
                        self._thirds(Cat(c.pair_x[px], c.pair_y[py], 1))))),
                    d_last_use[bank].eq(found.last_use),
                    d_since[bank].eq(found.last_use >= retired),
                    d_before[bank].eq(found.last_use < number),
                ]

        # Act. What may happen in a clock is known before it begins, but for credit and room.
        a_missing = Signal(TAG_BANKS)
        a_busy = Signal(TAG_BANKS)
        a_last_use = Signal(data.ArrayLayout(sequence, TAG_BANKS), reset_less=True)
        # Whether no tile is missing, or nobody is there; the lowest one may be claimed, and no
        # other one is missing.
        a_hit = Signal(init=1)
        a_open = Signal()
        a_final = Signal()
        complete = Signal()
        lowest = Signal(TAG_BANKS)
        others = Signal(TAG_BANKS)
        m.d.comb += [
            lowest.eq(self._lowest(a_missing)), others.eq(a_missing & ~lowest),
            self.claim.eq(a_open & self.credit),
            complete.eq(a_hit | (a_final & self.credit)),
            advance.eq(complete & room), self.push.eq(a_valid & advance),
            self.place.eq(a.place), self.misses.eq(a_misses + self.claim),
            self.stalls.interlock.eq(~a_hit & ~a_open),
            self.stalls.credit.eq(a_open & ~self.credit),
            self.stalls.pending.eq(a_valid & complete & ~room),
        ]

        def prospect(missing, busy):
            """``a_hit``, ``a_open`` and ``a_final`` with these banks missing and busy."""
            first = self._lowest(missing)
            may_claim = (first & ~busy).any()
            return ~missing.any(), may_claim, may_claim & ~(missing & ~first).any()

        missing = Signal(TAG_BANKS)
        busy = Signal(TAG_BANKS)
        m.d.comb += missing.eq(Cat(Mux(known, ~hit, ~same.all())
                                   for known, hit, same in zip(d_known, d_hit, d_same)))
        # Who was touched a moment ago counts as busy; the look-up that did it becomes the last
        # use in the first clock in A.
        a_touched = Signal(TAG_BANKS)
        a_new = Signal()
        busy_again = Signal(TAG_BANKS)
        m.d.sync += a_new.eq(advance)
        with m.If(advance):
            m.d.sync += [a_touched.eq(d_touched), a_last_use.eq(d_last_use)]
        for bank, last_use in enumerate(a_last_use):
            toucher = a_new & a_touched[bank]
            with m.If(~advance & toucher):
                # One addition: number - 1 - a_between.
                m.d.sync += last_use.eq(number + ~Cat(a_between[bank], Const(0, sequence - 2)))
            m.d.comb += [
                busy[bank].eq(d_touched[bank] | self._in_flight(
                    d_since[bank], d_before[bank], d_wrapped)),
                busy_again[bank].eq(toucher | self._in_flight(
                    last_use >= retired, last_use < number, wrapped))]
        states = (a_hit, a_open, a_final)
        with m.If(advance):
            m.d.sync += [a_misses.eq(0), a_missing.eq(Mux(d_valid, missing, 0)), a_busy.eq(busy)]
            hit, may_claim, final = prospect(missing, busy)
            m.d.sync += [a_hit.eq(~d_valid | hit), a_open.eq(d_valid & may_claim),
                         a_final.eq(d_valid & final)]
        with m.Else():
            m.d.sync += a_busy.eq(busy_again)
            with m.If(self.claim):
                m.d.sync += [a_missing.eq(others), a_misses.eq(a_misses + 1)]
                m.d.sync += [state.eq(new)
                             for state, new in zip(states, prospect(others, a_busy))]
            with m.Else():
                m.d.sync += [state.eq(new)
                             for state, new in zip(states, prospect(a_missing, a_busy))]
        px, py = lowest[1] | lowest[3], lowest[2] | lowest[3]
        m.d.comb += [
            self.tile.x.eq(Cat(px, Mux(px, a.pair_x[1], a.pair_x[0]))),
            self.tile.y.eq(Cat(py, Mux(py, a.pair_y[1], a.pair_y[0]))),
            self.tile.slot.eq(Cat(Mux(px, a.set_x[1], a.set_x[0])
                                  | Mux(py, a.set_y[1], a.set_y[0]), px, py)),
        ]
        return m

    def _clear(self, m):
        """Whether nothing is accepted, whether entries are made invalid, and of which set."""
        closed = Signal(init=1)
        clearing = Signal(init=1)
        clear_set = Signal(set_bits(self.options))
        with m.If(self.i.valid & self.i.ready & self._last(self.i.p.place)):
            m.d.sync += closed.eq(1)
        with m.If(self.push & self._last(self.place)):
            m.d.sync += clearing.eq(1)
        with m.If(clearing):
            m.d.sync += clear_set.eq(clear_set + 1)
            with m.If(clear_set == self.options.sets - 1):
                m.d.sync += [clearing.eq(0), closed.eq(0), clear_set.eq(0)]
        return closed, clearing, clear_set

    @staticmethod
    def _last(place):
        """Whether a look-up is a frame's last."""
        return place.last

    @staticmethod
    def _thirds(bits):
        third = -(-len(bits) // 3)
        return [bits[at:at + third] for at in range(0, len(bits), third)]

    @staticmethod
    def _lowest(bits):
        """The lowest bit that is set, alone."""
        return Cat(bit & ~bits[:k].any() for k, bit in enumerate(bits))

    @staticmethod
    def _in_flight(since, before, wrapped):
        """Whether a look-up is one of those passed on that still have to read.

        ``since``: its number is not below that of the oldest of these. ``before``: it is below
        that of the look-up in the act stage. ``wrapped``: this one is below that of the oldest.
        """
        return (since & before) | (wrapped & (since | before))
