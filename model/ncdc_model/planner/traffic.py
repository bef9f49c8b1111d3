"""Memory traffic of a map: minimum, worst case, and minimum size of a cache."""

import numpy as np

__all__ = ["SPAN", "distinct_bytes", "live_tiles", "worst_span"]

SPAN = 8192                                 # pixels
_ROWS = 64                                  # corrected rows at a time


def distinct_bytes(windows, geometry):
    """Number of samples, a byte each, of the raw frame that are in any window."""
    touched = np.zeros(geometry.distorted[::-1], bool)
    for top in range(0, len(windows.used), _ROWS):
        x0, y0, used = (array[top:top + _ROWS] for array in (windows.x0, windows.y0, windows.used))
        touched[y0[used], x0[used]] = True
    for axis in (0, 1):
        starts = np.moveaxis(touched, axis, 0).copy()
        grown = np.moveaxis(touched, axis, 0)
        for shift in range(1, windows.interpolation.after + 1):
            grown[shift:] |= starts[:-shift]
        for shift in range(1, windows.interpolation.margin + 1):
            grown[:-shift] |= starts[shift:]
    return int(touched.sum())


def worst_span(missed, lookups, tile_bytes, span=SPAN):
    """Bytes per look-up in the ``span`` consecutive look-ups that read most; tiles have
    ``tile_bytes``.

    A frame of fewer look-ups is one span.
    """
    span = min(span, lookups)
    until = np.searchsorted(missed.lookup, missed.lookup + span)
    most = (until - np.arange(len(missed))).max(initial=0)
    return float(most) * tile_bytes / span


def live_tiles(accessed):
    """Largest number of tiles between their first and last use at any time of the frame.

    A cache of that size reads no tile twice.
    """
    begins, ends = [], []
    for first, last, tile in accessed.banks:
        order = np.argsort(tile, kind="stable")         # by tile, its uses in order of time
        fresh = np.diff(tile[order], prepend=-1) != 0
        begins.append(first[order[fresh]])
        ends.append(last[order[np.roll(fresh, -1)]])
    begins, ends = (np.sort(np.concatenate(times)) for times in (begins, ends))
    over = np.searchsorted(ends, begins)                # tiles that ended before each begin
    return int((np.arange(1, len(begins) + 1) - over).max(initial=0))
