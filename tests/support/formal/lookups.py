"""Tag stage and retirement of the tile cache: right tiles, tokens, and an end of each wait."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import always, constant, given, inner, reached
from formal.queue_state import entries
from formal.wrapper import Wrapper
from ncdc_hdl.backend.cache.forwarding import EARLIER
from ncdc_hdl.backend.cache.layouts import Banks, lookup_layout, row_bits
from ncdc_hdl.backend.cache.retire import Retire
from ncdc_hdl.backend.cache.tags import Tags
from ncdc_hdl.lib.relay import Relay
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.interpolation import FAST

__all__ = ["Progress", "Slots", "Tokens"]

_BITS = 2                               # of a tile's column and row


class _Parts(Elaboratable):
    """``Tags`` and ``Retire``, joined as in ``Cache``."""

    def __init__(self, tags, retire):
        self.tags, self.retire = tags, retire

    def elaborate(self, platform):
        m = Module()
        m.submodules.tags, m.submodules.retire = tags, retire = self.tags, self.retire
        m.d.comb += [retire.push.eq(tags.push), retire.position.eq(tags.position),
                     retire.missing.eq(tags.missing), tags.retire.eq(retire.retire)]
        return m


class _Lookups(Wrapper):
    """``Tags`` and ``Retire`` with any look-ups, any consumer, and fills in order of any latency.

    Look-ups carry their tile in ``fx`` and ``fy``, whether their frame is odd in ``first``.
    """

    def __init__(self, split=0, tags=Tags, retire=Retire, needs=FAST):
        options = CacheOptions(tiles=16, pending=4, outstanding=2, sequence_bits=4,
                               interpolation=needs)
        self.options, self.split, self.rows = options, split, needs.tile_rows
        self.tags, self.retire = tags(_BITS, options), retire(_BITS, options, Banks(2, 8))
        self.odd_frame = Signal()
        super().__init__({
            "valid": In(1), "tile_x": In(_BITS), "tile_y": In(_BITS), "across": In(1),
            "down": In(range(self.rows)), "blank": In(1), "last": In(1), "filled": In(1),
            "space": In(1), "watch": In(4)} | ({"written": In(1)} if self.retire.shared else {}))

    def start(self, m):
        """The design with its look-ups and fills; its parts, and the tiles outstanding."""
        tags, retire, most = self.tags, self.retire, self.options.outstanding
        fragment = self.design(m, _Parts(tags, retire))
        m.d.comb += [tags.i.valid.eq(self.valid), tags.i.payload.eq(self._lookup(m)),
                     retire.o.space.eq(self.space)]
        if "written" in retire.signature.members:
            written = Signal()          # a clock ago it was said that words are written now
            m.d.sync += written.eq(self.written)
            m.d.comb += retire.written.eq(self.written)
            always(m, ~(retire.retire & written), "read_or_written")
        with m.If(tags.i.valid & tags.i.ready & self.last):
            m.d.sync += self.odd_frame.eq(~self.odd_frame)
        outstanding = Signal(range(most + 1))
        given(m, ~self.filled | (outstanding != 0))
        m.d.sync += outstanding.eq(outstanding + tags.claim - self.filled)
        m.d.comb += [tags.credit.eq(outstanding != most), retire.filled.eq(self.filled)]
        return fragment, outstanding

    def _set(self, pair_x, pair_y):
        """Set of a tile, by the index rule."""
        across = self.split
        return Cat(pair_x[:across], pair_y[:self.options.max_split - across])

    def _lookup(self, m):
        """The look-up of a window that begins at the input's tile."""
        lookup = Signal(lookup_layout(_BITS, self.options, 1))
        position, mask = lookup.position, (1 << self.split) - 1
        for odd in range(2):
            pair_x = (self.tile_x + (1 - odd)) >> 1
            m.d.comb += [lookup.pair_x[odd].eq(pair_x), lookup.set_x[odd].eq(pair_x & mask)]
        for row in range(self.rows):
            pair_y = (self.tile_y + (self.rows - 1 - row)) >> row_bits(self.options)
            m.d.comb += [lookup.pair_y[row].eq(pair_y), lookup.set_y[row].eq(pair_y << self.split)]
        for bank in range(self.options.tag_banks):
            m.d.comb += lookup.need[bank].eq(
                ~self.blank & (self.across | (self.tile_x[0] == bank & 1))
                & (self._below(self.tile_y, bank) <= self.down))
        m.d.comb += [
            position.lane[0].x.eq(Mux(self.across, 14, 0)),
            position.lane[0].y.eq(self.down << 1),
            position.lane[0].fx.eq(self.tile_x), position.lane[0].fy.eq(self.tile_y),
            position.lane[0].blank.eq(self.blank), position.last.eq(self.last),
            position.first.eq(self.odd_frame)]
        return lookup


    def _below(self, tile_y, bank):
        """Rows of tiles from row ``tile_y`` down to the next one that is in ``bank``."""
        bits = row_bits(self.options)
        return ((bank >> 1) - tile_y[:bits])[:bits]


class Slots(_Lookups):
    """Without resets: no window reads a slot that is not its tile's, or that is being written.

    Begins when the reset's clearing of all entries ends, which saves as many clocks as sets: the
    entries' memory begins with what clearing writes.

    A claimed tile may be written in each clock after its claim up to and including that of
    ``filled``; that is what ``FillOrder`` proves of the fills. One slot, any, is watched: which
    tile it holds, and whether it is being written. Asserts that a window whose samples lie in the
    watched slot reads it while it holds its tile, of its frame, and is not being written
    (``own_tile``), and that a slot is not claimed while it is being filled (``filled_once``).
    ``one_bank`` has windows within one tile only, of one bank, which allows of longer runs.
    """

    initial = {("tags", "clearing", "closed"): 0, ("tags", "clearing", "clearing"): 0}

    def __init__(self, split=0, one_bank=False, **parts):
        self.one_bank = one_bank
        super().__init__(split, **parts)

    def elaborate(self, platform):
        m = Module()
        tags, retire = self.tags, self.retire
        given(m, ~ResetSignal())
        if self.one_bank:
            given(m, ~(self.across | self.down | self.tile_x[0] | self.tile_y[0] | self.blank)
                  & (self.watch[2:] == 0))
        fragment, outstanding = self.start(m)

        # The watched slot.
        constant(m, self.watch)
        holds, held = Signal(), Signal(data.StructLayout(
            {"x": _BITS + 1, "y": _BITS + 1, "odd_frame": 1}))
        ahead = Signal.like(outstanding)              # fills until its own, included
        claimed, replaced = Signal(), Signal()
        # Whose tiles are claimed: the same two stages as in ``Claims``, for the frame alone.
        m.submodules.frames = frames = Relay(1)
        relay, odd_frame = tags.claims.relay, Signal()
        m.d.comb += [frames.i.valid.eq(tags.act.take), frames.i.payload.eq(tags.position.first),
                     frames.o.ready.eq(relay.o.ready)]
        with m.If(frames.o.valid & frames.o.ready):
            m.d.sync += odd_frame.eq(frames.o.payload)
        m.d.comb += claimed.eq(tags.claim & (tags.tile.slot == self.watch))
        with m.If(claimed):
            m.d.sync += [holds.eq(0), held.x.eq(tags.tile.x), held.y.eq(tags.tile.y),
                         held.odd_frame.eq(odd_frame),
                         ahead.eq(outstanding + 1 - self.filled), replaced.eq(replaced | holds)]
        with m.Elif(self.filled & (ahead != 0)):
            m.d.sync += ahead.eq(ahead - 1)
            with m.If(ahead == 1):
                m.d.sync += holds.eq(1)

        # The window that reads now.
        position = data.View(retire.position_shape, inner(fragment, "retire", "b"))
        lane = position.lane[0]
        reads, wrong = Signal(), Signal()
        for bank in range(self.options.tag_banks):
            tile_x, tile_y = Signal(_BITS + 1), Signal(_BITS + 1)
            below = self._below(lane.fy, bank)
            m.d.comb += [tile_x.eq(lane.fx + (lane.fx[0] != bank & 1)),
                         tile_y.eq(lane.fy + below)]
            needed = ((lane.fx[0] == bank & 1) | (lane.x > 13)) & (below <= lane.y >> 1)
            slot = Cat(self._set(tile_x >> 1, tile_y >> row_bits(self.options)),
                       Const(bank, 1 + row_bits(self.options)))
            with m.If(retire.retire & ~lane.blank & needed & (slot == self.watch)):
                m.d.comb += [reads.eq(1),
                             wrong.eq(~holds | (held.x != tile_x) | (held.y != tile_y)
                                      | (held.odd_frame != position.first))]
        always(m, ~wrong, "own_tile")
        always(m, ~claimed | (ahead == 0), "filled_once")
        reached(m, reads & replaced, "replaced")
        reached(m, reads & position.first, "next_frame")
        reached(m, tags.stalls.interlock & retire.retire, "interlock")
        return m


class Tokens(_Lookups):
    """Reset at any time: tokens and pending look-ups are counted right.

    Asserts that the balance of tokens and the tiles outstanding together are the tiles claimed by
    look-ups after the oldest, so that no token is spent that is not there, and that the queue
    does not overflow. No window is announced without space for it, and none of shared tile memory
    reads it while words are written.
    """

    def elaborate(self, platform):
        m = Module()
        retire, most = self.retire, self.options.pending
        fragment, outstanding = self.start(m)
        [queue] = self.queues
        balance, push, owed, oldest_valid, b_valid = (
            inner(fragment, "retire", name) for name in
            ("balance", "push", "owed", "oldest_valid", "b_valid"))
        a_valid = self.tags.act.valid
        ahead, memory = self.tags.forwarding, self.tags.memory
        a_hit, a_misses = (inner(fragment, "tags", "act", name) for name in ("a_hit", "a_misses"))
        left, done, final, bank = (inner(fragment, "tags", "claims", name)
                                   for name in ("left", "done", "final", "bank"))
        o_valid, o, free, full, aside = (inner(fragment, "tags", "claims", "relay", name)
                                         for name in ("o__valid", "o", "free", "full", "aside"))
        level, space, numbers, retirals = (
            inner(fragment, "tags", "pending", name) for name in
            ("level", "space", "numbers", "retirals"))

        granted = Signal(init=1)        # there was space a clock ago
        m.d.sync += granted.eq(self.space)
        always(m, granted | ~retire.o.issue, "issued_with_space")
        always(m, level == push + queue.level + oldest_valid + b_valid, "pushed_not_read")
        always(m, level <= most, "most_pending")
        always(m, space == (level != most), "space_flag")
        always(m, (numbers - retirals)[:len(numbers)] == level, "numbers")
        always(m, self.tags.pending.more == Cat(level > k for k in range(EARLIER)), "more_flags")
        # Tiles still to be claimed: `need` is at the end of a look-up's tiles.
        banks = self.options.tag_banks
        claiming, next_one, second = left[-banks:] | bank, o[-banks:], aside[-banks:]
        claimed = -(Mux(done, 0, sum(claiming)) + Mux(o_valid, sum(next_one), 0)
                    + Mux(free, 0, sum(second)))
        for number, (there, own) in enumerate([(push, owed), *(
                (there, item[-len(owed):].as_signed()) for there, item in entries(m, queue))]):
            claimed = claimed - Mux(there, own, 0)
            always(m, ~there | ((own <= 0) & (own >= -self.options.tag_banks)), f"misses{number}")
        # An empty stage misses nothing.
        always(m, ahead.c_valid | (ahead.known & ahead.hit).all(), "known_of_none")
        always(m, ahead.d_valid | ~memory.missing.any(), "missed_by_none")
        always(m, a_valid | ~self.tags.act.missing.any(), "claimed_for_none")
        always(m, a_hit == ~self.tags.act.missing.any(), "hit_flag")
        always(m, a_misses == ~a_hit, "miss_flag")
        always(m, full == ~free, "full_flag")
        always(m, done | claiming.any(), "some_to_claim")
        always(m, done | (bank == claiming & -claiming), "lowest_to_claim")
        always(m, done | ~(left[-banks:] & bank).any(), "others_to_claim")
        always(m, ~done | ~final, "final_one")
        always(m, done | (final == (sum(claiming) == 1)), "final_flag")
        always(m, ~o_valid | next_one.any(), "some_to_claim_next")
        always(m, free | (o_valid & second.any()), "some_to_claim_then")
        # What the oldest look-up waits for is under way.
        always(m, balance >= Mux(oldest_valid, -self.options.tag_banks, 0), "most_awaited")
        always(m, balance + outstanding == claimed, "tokens_and_fills")
        always(m, outstanding <= self.options.outstanding, "outstanding")
        reached(m, (level == most) & (outstanding != 0), "full")
        reached(m, (balance > 1) & retire.retire, "tokens_to_come")
        self.waits(m, outstanding, a_valid | (level != 0))
        return m

    def waits(self, m, outstanding, busy):
        """Say nothing of how long anything takes."""


class Progress(Tokens):
    """The same with a memory and a consumer that answer within ``_ANSWER`` clocks: each wait ends.

    Asserts that something happens every ``_WAIT`` clocks as long as there is a look-up: a claim,
    a fill, a push or a read. Each look-up has at most four claims and fills and one of the others,
    so each look-up ends.
    """

    _ANSWER, _WAIT = 2, 8

    def waits(self, m, outstanding, busy):
        tags, retire = self.tags, self.retire
        for awaited, answer in ((outstanding != 0, self.filled), (Const(1), self.space)):
            late = Signal(range(self._ANSWER + 1))
            m.d.sync += late.eq(Mux(awaited & ~answer, late + 1, 0))
            given(m, late < self._ANSWER)
        idle = Signal(range(self._WAIT + 2))
        happens = tags.claim | self.filled | tags.push | retire.retire
        m.d.sync += idle.eq(Mux(busy & ~happens, idle + 1, 0))
        always(m, idle <= self._WAIT, "something_happens")
        reached(m, idle == 3, "waits")
