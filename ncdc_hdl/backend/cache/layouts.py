"""Layouts of the streams between the parts of the cache."""

from collections import namedtuple

from amaranth.lib import data
from amaranth.utils import ceil_log2

from ncdc_model.fetch.cache_options import TAG_BANKS, TILE_HEIGHT, TILE_WIDTH
from ncdc_model.geometry import MAX_SIZE

__all__ = ["PAIR_X_BITS", "PAIR_Y_BITS", "TILE_X_BITS", "TILE_Y_BITS", "bank_tile",
           "lookup_layout", "set_bits", "slot_bits", "stalls_layout", "tile_layout", "tiles_layout",
           "tiles_of", "window_place_layout", "word_bytes"]

TILE_X_BITS = ceil_log2(MAX_SIZE // TILE_WIDTH)
TILE_Y_BITS = ceil_log2(MAX_SIZE // TILE_HEIGHT)
# Tiles come in pairs, an even one and the odd one behind it; a bank holds one of each pair.
PAIR_X_BITS, PAIR_Y_BITS = TILE_X_BITS - 1, TILE_Y_BITS - 1


def set_bits(options):
    """Bits of the number of a set."""
    return ceil_log2(options.sets)


def slot_bits(options):
    """Bits of the number of a slot: the bank above the set."""
    return ceil_log2(options.tiles)


def word_bytes(data_width, lanes):
    """Bytes that one bank of the tile memory gives per clock, see ``tiles``."""
    return 8 if data_width == 128 or lanes > 1 else 4


def window_place_layout(f_bits, options, lanes):
    """What a pending look-up has to know until its samples are read.

    ``set`` is that of its first tile, whose column and row parity are ``odd_tile``; ``next_set`` is
    that of the tile right of and below it. Each lane has its window's origin ``x``, ``y`` in the
    tile that holds it, the pixel's place ``fx``, ``fy`` in the window, and whether it is ``blank``.
    A group of several lanes may take several look-ups: ``mask`` tells which lanes are this one's,
    ``end`` whether it is the group's last, ``word`` and ``row`` where in the first tile its box
    begins.
    """
    fields = {
        "set": set_bits(options), "next_set": set_bits(options),
        "odd_tile": data.StructLayout({"x": 1, "y": 1}),
        "lane": data.ArrayLayout(data.StructLayout(
            {"x": ceil_log2(TILE_WIDTH), "y": ceil_log2(TILE_HEIGHT), "fx": f_bits, "fy": f_bits,
             "blank": 1}), lanes),
        "first": 1, "last": 1}
    if lanes > 1:
        fields |= {"mask": lanes, "end": 1, "word": 1, "row": ceil_log2(TILE_HEIGHT)}
    return data.StructLayout(fields)


def tiles_layout(options):
    """Up to 2 x 2 tiles, as a look-up names them.

    Index 0 of ``pair_x`` and ``set_x`` is for the even tile column of the box, 1 for the odd one;
    ``pair_y`` and ``set_y`` likewise for rows. Bank b = px | py << 1 holds the tile of the pairs
    ``pair_x[px]``, ``pair_y[py]`` in the set ``set_x[px] | set_y[py]``; bit b of ``need`` tells
    whether the box touches it.
    """
    return data.StructLayout({
        "pair_x": data.ArrayLayout(PAIR_X_BITS, 2),
        "pair_y": data.ArrayLayout(PAIR_Y_BITS, 2),
        "set_x": data.ArrayLayout(set_bits(options), 2),
        "set_y": data.ArrayLayout(set_bits(options), 2),
        "need": TAG_BANKS,
    })


def lookup_layout(f_bits, options, lanes):
    """The fields of :func:`tiles_layout`, and the ``place`` of the window that goes with them."""
    return data.StructLayout(tiles_layout(options).members
                             | {"place": window_place_layout(f_bits, options, lanes)})


def tiles_of(options, lookup):
    """The tiles of a view of :func:`lookup_layout`, as a view of :func:`tiles_layout`."""
    layout = tiles_layout(options)
    return data.View(layout, lookup.as_value()[:layout.size])


BankTile = namedtuple("BankTile", ["pair_x", "pair_y", "set"])


def bank_tile(tiles, bank):
    """Pairs and set of the tile that a view with the fields of :func:`tiles_layout` has in a bank.

    The set is that of the bank's entry; whether the tile is needed does not matter.
    """
    px, py = bank & 1, bank >> 1
    return BankTile(tiles.pair_x[px], tiles.pair_y[py], tiles.set_x[px] | tiles.set_y[py])


def tile_layout(options):
    """A tile to be read from memory, and the slot it is for."""
    return data.StructLayout({"x": TILE_X_BITS, "y": TILE_Y_BITS, "slot": slot_bits(options)})


def stalls_layout():
    """Why the look-up in the act stage waits.

    ``interlock``: the place of a missing tile is in use. ``credit``: too many tiles are under way.
    ``pending``: too many look-ups are. At most one of them is high.
    """
    return data.StructLayout({"interlock": 1, "credit": 1, "pending": 1})
