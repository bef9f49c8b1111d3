"""Reference model of the cache's tag stage: which accesses miss, and what they evict."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.planner.lookups import pieces
from ncdc_spec.cache_options import TILE_WIDTH
from ncdc_spec.interpolation import FAST, Interpolation

__all__ = ["Accesses", "Misses", "accesses", "miss_count", "misses"]

_TX = TILE_WIDTH.bit_length() - 1
_ROW = 12              # bits of a tile's column in its number


@dataclass(frozen=True)
class Accesses:
    """Tiles that the look-ups of a scan touch, by bank; runs of one tile are one entry.

    Parameters
    ----------
    banks : tuple of (first, last, tile)
        Three arrays of int32 for each tag bank: look-up in which a run of accesses to one tile
        begins, the last look-up of the run, the tile's number (row << 12 | column).
    lookups : int
        Look-ups of the scan, those that read nothing included.
    interpolation : Interpolation
        Determines the size of the tiles.
    """
    banks: tuple
    lookups: int
    interpolation: Interpolation = FAST


@dataclass(frozen=True)
class Misses:
    """Tiles to be read, in the order of the look-ups and, within one, of the banks.

    Parameters
    ----------
    lookup : ndarray of int64, shape (M,)
        The look-up that misses.
    bank : ndarray of int64, shape (M,)
    tile : ndarray of int64, shape (M,)
        Number of the tile: row << 12 | column.
    victim : ndarray of int64, shape (M,)
        The last look-up that used the slot's previous tile; -1 if it was empty.
    """
    lookup: np.ndarray
    bank: np.ndarray
    tile: np.ndarray
    victim: np.ndarray

    def __len__(self):
        return len(self.lookup)

    @property
    def columns(self):
        """Column of each tile."""
        return self.tile & ((1 << _ROW) - 1)

    @property
    def rows(self):
        """Row of each tile."""
        return self.tile >> _ROW


def accesses(boxes):
    """:class:`Accesses` of the look-ups ``boxes`` (:class:`ncdc_model.planner.lookups.Lookups`)."""
    rows_apart = boxes.interpolation.tile_rows - 1      # from one tile row of a bank to the next
    ty = boxes.interpolation.tile_height.bit_length() - 1
    first, last, (left, right, top, bottom) = _all_runs(boxes, ty)
    banks = []
    for bank in range(2 * (rows_apart + 1)):
        column = left + ((left ^ bank) & 1)
        row = top + ((bank >> 1) - top & rows_apart)
        touched = np.flatnonzero((column <= right) & (row <= bottom))
        tile = row[touched].astype(np.int32) << _ROW | column[touched]
        begin = np.flatnonzero(np.diff(tile, prepend=-1))
        end = np.append(begin, len(touched))[1:] - 1
        banks.append((first[touched[begin]], last[touched[end]], tile[begin]))
    return Accesses(tuple(banks), len(boxes), boxes.interpolation)


def _all_runs(boxes, ty):
    """First and last look-up of each run of look-ups that touch the same tiles, and those tiles'
    first and last column, first and last row; ``ty``: log2 of a tile's rows.

    Neighbours mostly touch the same tiles: a run becomes one access.
    """
    parts = []
    for piece in pieces(len(boxes)):
        used = (piece.start + np.flatnonzero(boxes.used[piece])).astype(np.int32)
        edges = (boxes.x0[used] >> _TX, boxes.x1[used] >> _TX, boxes.y0[used] >> ty,
                 boxes.y1[used] >> ty)
        parts.append(_runs(used, used, edges))
    firsts, lasts, edges = zip(*parts)
    # A run may continue from one piece to the next.
    return _runs(np.concatenate(firsts), np.concatenate(lasts),
                 [np.concatenate(edge) for edge in zip(*edges)])


def _runs(first, last, edges):
    """The runs ``first`` to ``last`` of look-ups, each with ``edges``, four arrays: neighbours of
    equal edges are joined. Returns (first, last, edges)."""
    fresh = np.ones(len(first), bool)
    fresh[1:] = np.logical_or.reduce([np.diff(edge) != 0 for edge in edges])
    start = np.flatnonzero(fresh)
    end = np.append(start, len(first))[1:] - 1
    return first[start], last[end], [edge[start] for edge in edges]


def misses(accessed, options, split):
    """:class:`Misses` of a cache that starts empty.

    The cache is direct mapped: an access misses unless the previous access to its slot was to the
    same tile.

    Parameters
    ----------
    accessed : Accesses
    options : CacheOptions
    split : int
        log2 of the sets along a tile's column.

    Raises
    ------
    InputError
        If the cache has no such split.
    """
    options.check_split(split)
    found = []
    for bank, (first, last, tile) in enumerate(accessed.banks):
        slot = _slots(tile, options, split)
        order = np.argsort(slot, kind="stable")
        same_slot = np.diff(slot[order], prepend=slot[order[:1]] + 1) == 0
        missed = ~same_slot | (np.diff(tile[order], prepend=-1) != 0)
        before = np.where(same_slot, np.roll(last[order], 1), -1)
        which = order[missed]
        found.append((first[which], np.full(len(which), bank), tile[which], before[missed]))
    lookup, bank, tile, victim = (np.concatenate(part, dtype=np.int64) for part in zip(*found))
    order = np.lexsort((bank, lookup))
    return Misses(lookup[order], bank[order], tile[order], victim[order])


def miss_count(accessed, options, split):
    """Number of :func:`misses`; parameters and errors are theirs."""
    options.check_split(split)
    count = 0
    for _, _, tile in accessed.banks:
        # Equal tiles have equal slots.
        by_slot = tile[np.argsort(_slots(tile, options, split), kind="stable")]
        count += np.count_nonzero(np.diff(by_slot, prepend=-1))
    return int(count)


def _slots(tile, options, split):
    """Slot in its bank of each tile, uint16."""
    kx, ky = 1 << split, options.sets >> split
    across = options.tile_rows.bit_length() - 1
    column, row = tile & ((1 << _ROW) - 1), tile >> _ROW
    return ((row >> across & (ky - 1)) * kx + (column >> 1 & (kx - 1))).astype(np.uint16)
