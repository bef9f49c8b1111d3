"""Tag stage and retirement of the tile cache: no window reads a place that is not its tile's."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In

from formal.properties import Wrapper, always, constant, given, inner, reached
from ncdc_hdl.backend.cache.layouts import lookup_layout
from ncdc_hdl.backend.cache.retire import Retire
from ncdc_hdl.backend.cache.tags import Tags
from ncdc_model.fetch.cache_options import TAG_BANKS, CacheOptions

__all__ = ["Lookups"]

_BITS = 2                               # of a tile's column and row


class _Parts(Elaboratable):
    """``Tags`` and ``Retire``, joined as in ``Cache``."""

    def __init__(self, tags, retire):
        self.tags, self.retire = tags, retire

    def elaborate(self, platform):
        m = Module()
        m.submodules.tags, m.submodules.retire = tags, retire = self.tags, self.retire
        m.d.comb += [retire.push.eq(tags.push), retire.place.eq(tags.place),
                     retire.misses.eq(tags.misses), tags.retire.eq(retire.retire)]
        return m


class Lookups(Wrapper):
    """``Tags`` and ``Retire`` with any look-ups, any consumer, and fills in order of any latency.

    A claimed tile may be written in each clock after its claim up to and including that of
    ``filled``; that is what ``FillOrder`` proves of the fills. One place, any, is watched: which
    tile it holds, and whether it is being written. Look-ups carry their tile in ``fx`` and ``fy``.

    Asserts that a window whose samples lie in the watched place reads it while it holds its tile
    and is not being written; that a place is not claimed while it is being filled; that tokens
    are tiles filled and not consumed; that the queue does not overflow.
    """

    def __init__(self, split=0, tags=Tags, retire=Retire, only=None):
        options = CacheOptions(tiles=16, pending=4, outstanding=2, sequence_bits=4)
        self.options, self.split, self.only = options, split, only
        self.tags, self.retire = tags(_BITS, options), retire(_BITS, options, 8)
        super().__init__({
            "valid": In(1), "tile_x": In(_BITS), "tile_y": In(_BITS), "across": In(1), "down": In(1),
            "blank": In(1), "last": In(1), "filled": In(1), "ready": In(1), "watch": In(4)})

    def elaborate(self, platform):
        m = Module()
        tags, retire, options = self.tags, self.retire, self.options
        given(m, ~ResetSignal())
        fragment = self.design(m, _Parts(tags, retire))
        [queue] = self.queues
        m.d.comb += [tags.i.valid.eq(self.valid), tags.i.payload.eq(self._lookup(m)),
                     retire.o.ready.eq(self.ready)]

        outstanding = Signal(range(options.outstanding + 1))
        given(m, ~self.filled | (outstanding != 0))
        m.d.sync += outstanding.eq(outstanding + tags.claim - self.filled)
        m.d.comb += [tags.credit.eq(outstanding != options.outstanding),
                     retire.filled.eq(self.filled)]

        # The watched place.
        constant(m, self.watch)
        holds, held = Signal(), Signal(data.StructLayout({"x": _BITS + 1, "y": _BITS + 1}))
        ahead = Signal(range(options.outstanding + 1))    # fills until its own, included
        claimed = Signal()
        m.d.comb += claimed.eq(tags.claim & (tags.tile.slot == self.watch))
        with m.If(claimed):
            m.d.sync += [holds.eq(0), held.x.eq(tags.tile.x), held.y.eq(tags.tile.y),
                         ahead.eq(outstanding + 1 - self.filled)]
        with m.Elif(self.filled & (ahead != 0)):
            m.d.sync += ahead.eq(ahead - 1)
            with m.If(ahead == 1):
                m.d.sync += holds.eq(1)
        self._always(m, ~claimed | (ahead == 0), "filled_once")

        # The window that reads now.
        lane = data.View(retire.place_shape, inner(fragment, "retire", "b")).lane[0]
        reads, wrong, read = Signal(), Signal(), Signal()
        m.d.comb += reads.eq(retire.retire & ~lane.blank)
        for bank in range(TAG_BANKS):
            tile_x, tile_y = Signal(_BITS + 1), Signal(_BITS + 1)
            m.d.comb += [tile_x.eq(lane.fx + (lane.fx[0] != bank & 1)),
                         tile_y.eq(lane.fy + (lane.fy[0] != bank >> 1))]
            needed = (((lane.fx[0] == bank & 1) | (lane.x > 13))
                      & ((lane.fy[0] == bank >> 1) | (lane.y > 1)))
            slot = Cat(self._set(tile_x >> 1, tile_y >> 1), Const(bank, 2))
            with m.If(reads & needed & (slot == self.watch)):
                m.d.comb += wrong.eq(~holds | (held.x != tile_x) | (held.y != tile_y))
                m.d.comb += read.eq(1)
        self._always(m, ~wrong, "own_tile")

        # Tokens and the queue.
        tokens, level = inner(fragment, "retire", "tokens"), inner(fragment, "tags", "level")
        behind = [inner(fragment, "retire", name) for name in ("oldest_valid", "b_valid")]
        self._always(m, level == queue.level + sum(behind), "pushed_not_read")
        self._always(m, level <= options.pending, "most_pending")
        self._always(m, tokens <= TAG_BANKS * (options.pending + 1), "tokens_fit")
        replaced = Signal()
        with m.If(claimed & holds):
            m.d.sync += replaced.eq(1)
        reached(m, read & replaced, "replaced")
        reached(m, tags.stalls.interlock & (queue.level != 0), "interlock")
        return m

    def _always(self, m, condition, name):
        if self.only in (None, name):
            always(m, condition, name)

    def _set(self, pair_x, pair_y):
        """Set of a tile, by the index rule."""
        across = self.split
        return Cat(pair_x[:across], pair_y[:2 - across])

    def _lookup(self, m):
        """The look-up of a window that begins at the input's tile."""
        lookup = Signal(lookup_layout(_BITS, self.options, 1))
        place, mask = lookup.place, (1 << self.split) - 1
        for odd in range(2):
            pair_x, pair_y = (self.tile_x + (1 - odd)) >> 1, (self.tile_y + (1 - odd)) >> 1
            m.d.comb += [
                lookup.pair_x[odd].eq(pair_x), lookup.pair_y[odd].eq(pair_y),
                lookup.set_x[odd].eq(pair_x & mask), lookup.set_y[odd].eq(pair_y << self.split)]
        for bank in range(TAG_BANKS):
            m.d.comb += lookup.need[bank].eq(
                ~self.blank & (self.across | (self.tile_x[0] == bank & 1))
                & (self.down | (self.tile_y[0] == bank >> 1)))
        m.d.comb += [
            place.lane[0].x.eq(Mux(self.across, 14, 0)),
            place.lane[0].y.eq(Mux(self.down, 2, 0)),
            place.lane[0].fx.eq(self.tile_x), place.lane[0].fy.eq(self.tile_y),
            place.lane[0].blank.eq(self.blank), place.last.eq(self.last)]
        return lookup
