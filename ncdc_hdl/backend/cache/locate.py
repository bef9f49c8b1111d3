"""From boxes of samples to the tiles that they touch."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.cache.boxes import box_layout
from ncdc_hdl.backend.cache.layouts import (
    PAIR_X_BITS,
    lanes_set_to,
    lookup_layout,
    pair_y_bits,
    row_bits,
    set_bits,
)
from ncdc_hdl.lib.pipeline import register
from ncdc_hdl.lib.relay import Relay
from ncdc_spec.cache_options import TILE_WIDTH

__all__ = ["Locate"]

_X_BITS = ceil_log2(TILE_WIDTH)


class Locate(wiring.Component):
    """Tiles and sets of each box, by the index rule of ``CacheOptions``.

    Timing: two stream stages, one box per clock; the second one is a :class:`Relay`.

    Parameters
    ----------
    f_bits, options, lanes
        As in :class:`ncdc_hdl.backend.cache.cache.Cache`.

    Members
    -------
    split : ``In``
        log2 Kx, constant while boxes are under way.
    i : ``In(stream.Signature(box_layout(f_bits, lanes)))``
    o : ``Out(stream.Signature(lookup_layout(f_bits, options, lanes)))``
    """

    latency = 1 + Relay.latency
    capacity = 1 + Relay.capacity
    """Boxes in it, at most."""

    def __init__(self, f_bits, options, lanes=1):
        self.options, self.lanes = options, lanes
        super().__init__({
            "split": In(range(set_bits(options) + 1)),
            "i": In(stream.Signature(box_layout(f_bits, lanes, options.interpolation))),
            "o": Out(stream.Signature(lookup_layout(f_bits, options, lanes))),
        })

    def elaborate(self, platform):
        m = Module()
        y_bits, rows = ceil_log2(self.options.tile_height), self.options.tile_rows
        row = row_bits(self.options)
        # T: the tiles of the box are known.
        t_valid = Signal()                              # there is a box in this stage
        t = Signal(self.i.payload.shape())              # the box
        t_across = Signal()                             # it reaches into the tile on the right
        t_down = Signal(row)                            # rows of tiles below in the box
        t_even_x = Signal(PAIR_X_BITS, reset_less=True)     # the pair of its even tile column
        # The pair, or the four, of its tile row of each kind but the last one.
        t_pair_y = [Signal(pair_y_bits(self.options), name=f"t_pair_y{r}", reset_less=True)
                    for r in range(rows - 1)]
        # S: the sets are known. The relay ends the path of ``ready``.
        m.submodules.sets = sets = Relay(self.o.payload.shape())
        wiring.connect(m, sets.o, wiring.flipped(self.o))
        o, position = sets.i.p, sets.i.p.position
        tile_x, tile_y = t.x0[_X_BITS:], t.y0[y_bits:]
        # Both in registers here, as the set of registers is far away.
        split, mask_x = register(m, "split_here", self.split), Signal(set_bits(self.options))
        m.d.sync += mask_x.eq((1 << self.split) - 1)
        # A register alone decides: `ready` goes on to all stages that make boxes of a group.
        m.d.comb += self.i.ready.eq(sets.i.ready)
        with m.If(sets.i.ready):
            # A box is narrower and lower than a tile or two: the lowest bits decide.
            m.d.sync += [
                t_valid.eq(self.i.valid), t.eq(self.i.payload),
                t_across.eq(self.i.p.x0[_X_BITS] ^ self.i.p.x1[_X_BITS]),
                t_down.eq(self.i.p.y1[y_bits:][:row] - self.i.p.y0[y_bits:][:row]),
                # After an odd column, the even one is in the next pair.
                t_even_x.eq((self.i.p.x0[_X_BITS:] + 1) >> 1),
                *(t_pair_y[r].eq((self.i.p.y0[y_bits:] + (rows - 1 - r)) >> row)
                  for r in range(rows - 1)),
            ]
        m.d.comb += [sets.i.valid.eq(t_valid),
                     position.odd_tile.x.eq(tile_x[0]), position.odd_tile.y.eq(tile_y)]
        self._position(m, position, t)
        # The tile after an even one is in the same pair, that after an odd one in the next.
        # Not read back from ``o``: simulators treat a vector as one signal.
        set_x = [Signal(len(mask_x), name=f"set_x{odd}") for odd in range(2)]
        set_y = [Signal(len(mask_x), name=f"set_y{r}") for r in range(rows)]
        for odd, pair_x in enumerate((t_even_x, tile_x[1:])):
            m.d.comb += [set_x[odd].eq(pair_x & mask_x),
                         o.pair_x[odd].eq(pair_x), o.set_x[odd].eq(set_x[odd])]
        for r, pair_y in enumerate((*t_pair_y, tile_y[row:])):
            m.d.comb += [set_y[r].eq(pair_y << split),
                         o.pair_y[r].eq(pair_y), o.set_y[r].eq(set_y[r])]
        m.d.comb += [position.next_set.eq(set_x[0] | set_y[0]),
        position.set.eq(set_x[1] | set_y[-1])]
        self._needs(m, o.need, t.used, (tile_x[0], t_across), (tile_y[:row], t_down))
        return m

    def _position(self, m, position, box):
        """What of a box is neither its tiles nor their sets."""
        m.d.comb += [position.first.eq(box.group.first),
                     position.last.eq(box.group.last & box.end)]
        if self.lanes == 1:
            m.d.comb += lanes_set_to(position.lane, box.group)
        else:
            m.d.comb += [position.mask.eq(box.mask), position.end.eq(box.end)]
        if "word" in position.shape().members:
            m.d.comb += [position.word.eq(box.x0[_X_BITS - len(position.word):]),
                         position.row.eq(box.y0)]

    def _needs(self, m, need, used, columns, rows):
        """Which banks a box needs: ``columns`` and ``rows`` are what its first tile leaves, divided
        by their number of banks, and the number of further ones that it reaches into."""
        for bank in range(self.options.tag_banks):
            below = Signal.like(rows[0], name=f"below{bank}")   # rows from the first one to this
            m.d.comb += [
                below.eq((bank >> 1) - rows[0]),
                need[bank].eq(used & (columns[1] | (columns[0] == bank & 1)) & (below <= rows[1]))]
