"""Layouts of the streams between the parts of the cache."""

from collections import namedtuple

from amaranth.lib import data
from amaranth.utils import ceil_log2

from ncdc_hdl.backend.layouts import edges
from ncdc_hdl.lib.groups import lanes_of
from ncdc_spec.cache_options import TILE_WIDTH
from ncdc_spec.geometry import MAX_SIZE

__all__ = ["Banks", "PAIR_X_BITS", "TILE_X_BITS", "bank_tile", "banks_for", "lanes_layout",
           "lanes_set_to", "lookup_layout", "pair_y_bits", "row_bits", "set_bits", "slot_bits",
           "stalls_layout", "tile_layout", "tile_y_bits", "tiles_layout", "tiles_of",
           "window_position_layout"]

TILE_X_BITS = ceil_log2(MAX_SIZE // TILE_WIDTH)
# Tiles come in pairs, an even one and the odd one after it; a bank holds one of each pair. Rows of
# tiles come likewise in pairs, or fours if a look-up may touch more than two.
PAIR_X_BITS = TILE_X_BITS - 1


def tile_y_bits(options):
    """Bits of the number of a tile's row."""
    return ceil_log2(MAX_SIZE // options.tile_height)


def row_bits(options):
    """Bits of a tile's row within its pair, or its four."""
    return ceil_log2(options.tile_rows)


def pair_y_bits(options):
    """Bits of the number of a pair of rows of tiles, or of a four."""
    return tile_y_bits(options) - row_bits(options)


def set_bits(options):
    """Bits of the number of a set."""
    return ceil_log2(options.sets)


def slot_bits(options):
    """Bits of the number of a slot: the bank above the set."""
    return ceil_log2(options.tiles)


class Banks(namedtuple("Banks", ["across", "word_bytes"])):
    """Banks of the tile memory side by side, and bytes of the word that each outputs per clock."""

    @property
    def columns(self):
        """Samples of a row that all of them output."""
        return self.across * self.word_bytes


_SHARED_WORD = 2        # bytes: what a port of a block RAM that reads and writes has on any device


def banks_for(data_width, lanes, interpolation, shared=False):
    """The :class:`Banks` of a cache, ``shared`` or not, see
    :class:`ncdc_hdl.backend.cache.tiles.Tiles`. A window at any position is in two words of four
    bytes only if it has at most five columns."""
    if shared:
        return Banks(1 << ceil_log2(interpolation.window // _SHARED_WORD + 1), _SHARED_WORD)
    if lanes > 1 or interpolation.window > 5:
        return Banks(*interpolation.box_words(lanes))
    return Banks(2, 8 if data_width == 128 else 4)


def lanes_layout(f_bits, options, lanes):
    """What the windows of a group need once their samples are read.

    A lane has the low bits ``x``, ``y`` of the sample of its first point, the pixel's position
    ``fx``, ``fy`` relative to it, ``blank``, and :func:`edges`.
    """
    needs = options.interpolation
    return data.ArrayLayout(data.StructLayout(
        {"x": ceil_log2(TILE_WIDTH), "y": ceil_log2(needs.box_rows),
         "fx": f_bits, "fy": f_bits, "blank": 1, **edges(needs)}), lanes)


def lanes_set_to(lanes, group):
    """Statements that set ``lanes``, of :func:`lanes_layout`, to those of a requested ``group``."""
    return [lane[name].eq(pixel[{"x": "x0", "y": "y0"}.get(name, name)])
            for lane, pixel in zip(lanes, lanes_of(group)) for name in dict(lane.shape())]


def window_position_layout(f_bits, options, lanes):
    """State of a pending look-up until its samples are read.

    ``set`` is that of its first tile, whose column modulo 2 and row modulo R are ``odd_tile``.
    ``next_set`` is that of the next tiles of the same bank to the right and below. ``lane`` is
    :func:`lanes_layout` of a single one. A group of several lanes may take several look-ups, and
    waits elsewhere: ``mask`` marks the lanes of this one, ``end`` the
    group's last one. The box begins at ``word`` and ``row`` of the first tile; of a single window
    ``word`` counts those of the shortest banks. One without a margin begins at its ``x`` and ``y``.
    """
    needs = options.interpolation
    word = _SHARED_WORD if lanes == 1 else needs.box_words(lanes)[1]
    fields = {
        "set": set_bits(options), "next_set": set_bits(options),
        "odd_tile": data.StructLayout({"x": 1, "y": row_bits(options)}),
        **({"lane": lanes_layout(f_bits, options, 1)} if lanes == 1 else {}),
        "first": 1, "last": 1}
    if lanes > 1:
        fields |= {"mask": lanes, "end": 1}
    if lanes > 1 or needs.margin:
        fields |= {"word": ceil_log2(TILE_WIDTH // word), "row": ceil_log2(options.tile_height)}
    return data.StructLayout(fields)


def tiles_layout(options):
    """Up to 2 x R tiles, of a look-up.

    Index 0 of ``pair_x`` and ``set_x`` is for the even tile column of the box, 1 for the odd one;
    ``pair_y`` and ``set_y`` for rows modulo R. Bank b = px | py << 1 holds the tile of the pairs
    ``pair_x[px]``, ``pair_y[py]`` in the set ``set_x[px] | set_y[py]``. Bit b of ``need`` is
    high if the box touches it.
    """
    return data.StructLayout({
        "pair_x": data.ArrayLayout(PAIR_X_BITS, 2),
        "pair_y": data.ArrayLayout(pair_y_bits(options), options.tile_rows),
        "set_x": data.ArrayLayout(set_bits(options), 2),
        "set_y": data.ArrayLayout(set_bits(options), options.tile_rows),
        "need": options.tag_banks,
    })


def lookup_layout(f_bits, options, lanes):
    """The fields of :func:`tiles_layout`, and the ``position`` of their window."""
    return data.StructLayout(tiles_layout(options).members
                             | {"position": window_position_layout(f_bits, options, lanes)})


def tiles_of(options, lookup):
    """The tiles of a view of :func:`lookup_layout`, as a view of :func:`tiles_layout`."""
    layout = tiles_layout(options)
    return data.View(layout, lookup.as_value()[:layout.size])


BankTile = namedtuple("BankTile", ["pair_x", "pair_y", "set"])


def bank_tile(tiles, bank):
    """Pairs and set of the tile that a view with the fields of :func:`tiles_layout` has in a bank.

    The set is that of the bank's entry; the tile need not be needed.
    """
    px, py = bank & 1, bank >> 1
    return BankTile(tiles.pair_x[px], tiles.pair_y[py], tiles.set_x[px] | tiles.set_y[py])


def tile_layout(options):
    """A tile to be read from memory, and the slot it is for."""
    return data.StructLayout({"x": TILE_X_BITS, "y": tile_y_bits(options),
                              "slot": slot_bits(options)})


def stalls_layout():
    """Reasons for a look-up to wait in the act stage.

    ``interlock``: the slot of a missing tile is in use. ``credit``: it misses tiles, and those of
    look-ups before it wait to be claimed, as too many are under way.
    ``pending``: too many look-ups are under way. At most one of them is high.
    """
    return data.StructLayout({"interlock": 1, "credit": 1, "pending": 1})
