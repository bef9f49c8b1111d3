"""The tag stage: which tiles are there, which are claimed, and when."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from ncdc_hdl.backend.cache.layouts import (PAIR_X_BITS, PAIR_Y_BITS, lookup_layout, set_bits,
                                            stalls_layout, tile_layout, window_place_layout)
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

    Entries are read two shifts before the act stage; what is passed on in between is forwarded.
    After a frame's last look-up, and after reset, all entries are made invalid, a set per clock,
    and nothing is accepted meanwhile; they keep a last user, so that the interlock holds.

    Timing: three stages that shift together; one look-up per clock, and one more clock for each
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
        number = Signal(sequence)                       # of the look-up in the act stage
        retired = Signal(sequence)                      # of the oldest that still has to read
        level = Signal(range(options.pending + 1))      # number - retired
        room, advance = Signal(), Signal()
        m.d.sync += [number.eq(number + self.push), retired.eq(retired + self.retire),
                     level.eq(level + self.push - self.retire)]

        # R: entries leave the memory. C: they are compared. A: act.
        stage = data.StructLayout({"lookup": lookup, "touched": TAG_BANKS, "present": TAG_BANKS,
                                   "toucher": data.ArrayLayout(sequence, TAG_BANKS)})
        r_valid, c_valid, a_valid = Signal(), Signal(), Signal()
        r, c = Signal(stage, reset_less=True), Signal(stage, reset_less=True)
        c_entry = Signal(data.ArrayLayout(entry, TAG_BANKS), reset_less=True)
        a = Signal(lookup, reset_less=True)
        a_missing = Signal(TAG_BANKS)
        a_busy = Signal(TAG_BANKS)
        a_misses = Signal.like(self.misses)
        a_last_use = Signal(data.ArrayLayout(sequence, TAG_BANKS), reset_less=True)

        closed, clearing, clear_set = self._clear(m)
        m.d.comb += self.i.ready.eq(advance & ~closed)
        with m.If(advance):
            m.d.sync += [r_valid.eq(self.i.valid & self.i.ready), c_valid.eq(r_valid),
                         a_valid.eq(c_valid)]

        # A look-up moves while the one in A is passed on: it inherits what that one wrote.
        def shifted(item, touched, present, toucher):
            """Signals of an item as it leaves its stage."""
            out_touched, out_present = Signal(TAG_BANKS), Signal(TAG_BANKS)
            out_toucher = Signal(data.ArrayLayout(sequence, TAG_BANKS))
            for bank in range(TAG_BANKS):
                px, py = bank & 1, bank >> 1
                same_set = ((item.set_x[px] == a.set_x[px]) & (item.set_y[py] == a.set_y[py]))
                same_tile = ((item.pair_x[px] == a.pair_x[px])
                             & (item.pair_y[py] == a.pair_y[py]))
                touch = self.push & a.need[bank] & same_set
                m.d.comb += [
                    out_touched[bank].eq(touched[bank] | touch),
                    out_present[bank].eq(Mux(touch, same_tile, present[bank])),
                    out_toucher[bank].eq(Mux(touch, number, toucher[bank])),
                ]
            return out_touched, out_present, out_toucher

        nothing = Const(0, TAG_BANKS)
        i_touch = shifted(self.i.p, nothing, nothing, [Const(0, sequence)] * TAG_BANKS)
        r_touch = shifted(r.lookup, r.touched, r.present, r.toucher)
        c_touch = shifted(c.lookup, c.touched, c.present, c.toucher)
        with m.If(advance):
            m.d.sync += r.lookup.eq(self.i.payload)
            m.d.sync += [field.eq(value) for field, value in zip((r.touched, r.present, r.toucher),
                                                                 i_touch)]
            m.d.sync += c.lookup.eq(r.lookup)
            m.d.sync += [field.eq(value) for field, value in zip((c.touched, c.present, c.toucher),
                                                                 r_touch)]

        written = Signal(sequence)                      # the last look-up passed on
        with m.If(self.push):
            m.d.sync += written.eq(number)
        for bank in range(TAG_BANKS):
            px, py = bank & 1, bank >> 1
            m.submodules[f"entries{bank}"] = memory = Memory(shape=entry, depth=options.sets,
                                                             init=[])
            read, write = memory.read_port(), memory.write_port()
            m.d.comb += [
                read.addr.eq(self.i.p.set_x[px] | self.i.p.set_y[py]), read.en.eq(advance),
                write.en.eq(clearing | (self.push & a.need[bank])),
                write.addr.eq(Mux(clearing, clear_set, a.set_x[px] | a.set_y[py])),
                write.data.valid.eq(~clearing),
                write.data.pair_x.eq(a.pair_x[px]), write.data.pair_y.eq(a.pair_y[py]),
                write.data.last_use.eq(Mux(clearing, written, number)),
            ]
            found = c_entry[bank]
            present = (found.valid & (found.pair_x == c.lookup.pair_x[px])
                       & (found.pair_y == c.lookup.pair_y[py]))
            touched, touch_present, toucher = (field[bank] for field in c_touch)
            with m.If(advance):
                m.d.sync += [
                    c_entry[bank].eq(read.data),
                    a_missing[bank].eq(c.lookup.need[bank]
                                       & ~Mux(touched, touch_present, present)),
                    a_last_use[bank].eq(Mux(touched, toucher, found.last_use)),
                    # Who was touched a moment ago is taken for busy until looked at again.
                    a_busy[bank].eq(touched | self._in_flight(found.last_use, retired, level)),
                ]

        # Act.
        lowest = Signal(TAG_BANKS)
        may_claim, complete = Signal(), Signal()
        m.d.comb += [
            lowest.eq(a_missing & -a_missing),
            may_claim.eq(a_valid & a_missing.any() & self.credit & ~(a_busy & lowest).any()),
            self.claim.eq(may_claim),
            complete.eq((a_missing & ~lowest) == 0),
            room.eq(level != options.pending),
            self.push.eq(a_valid & room & complete & (may_claim | ~a_missing.any())),
            advance.eq(~a_valid | self.push),
            self.place.eq(a.place), self.misses.eq(a_misses + self.claim),
            self.stalls.interlock.eq(a_valid & (a_busy & lowest).any()),
            self.stalls.credit.eq(a_valid & a_missing.any() & ~(a_busy & lowest).any()
                                  & ~self.credit),
            self.stalls.pending.eq(a_valid & ~room & complete & (may_claim | ~a_missing.any())),
        ]
        with m.If(advance):
            m.d.sync += [a.eq(c.lookup), a_misses.eq(0)]
        with m.Else():
            with m.If(self.claim):
                m.d.sync += [a_missing.eq(a_missing & ~lowest), a_misses.eq(a_misses + 1)]
            # One comparator serves whichever bank has its turn.
            for bank in range(TAG_BANKS):
                with m.If(lowest[bank]):
                    m.d.sync += a_busy[bank].eq(
                        self._in_flight(self._of(lowest, a_last_use), retired, level))
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
    def _of(one_hot, values):
        """The value whose bit is set in ``one_hot``."""
        result = 0
        for bit, value in zip(one_hot, values):
            result = result | Mux(bit, value, 0)
        return result

    @staticmethod
    def _in_flight(last_use, retired, level):
        """Whether look-up ``last_use`` is one of the ``level`` from ``retired`` on."""
        return (last_use - retired)[:len(last_use)] < level
