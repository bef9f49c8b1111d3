"""What a map demands of the memory, whatever fetches it, and what the cache makes of it."""

import numpy as np

__all__ = ["SPAN", "distinct_bytes", "live_tiles", "worst_span"]

SPAN = 8192                                 # pixels


def distinct_bytes(windows, geometry):
    """Samples of the raw frame that some window of the frame holds, a byte each."""
    touched = np.zeros(geometry.distorted[::-1], bool)
    touched[windows.y0[windows.used], windows.x0[windows.used]] = True
    for axis in (0, 1):
        starts = np.moveaxis(touched, axis, 0).copy()
        grown = np.moveaxis(touched, axis, 0)
        for shift in range(1, windows.interpolation.after + 1):
            grown[shift:] |= starts[:-shift]
        for shift in range(1, windows.interpolation.margin + 1):
            grown[:-shift] |= starts[shift:]
    return int(touched.sum())


def worst_span(missed, lookups, tile_bytes, span=SPAN):
    """Bytes per look-up in the ``span`` look-ups in a row that read most, of tiles of
    ``tile_bytes``.

    A frame of fewer look-ups is one span.
    """
    span = min(span, lookups)
    until = np.searchsorted(missed.lookup, missed.lookup + span)
    most = (until - np.arange(len(missed))).max(initial=0)
    return float(most) * tile_bytes / span


def live_tiles(accessed):
    """Tiles between their first and their last use, at most at any time of the frame.

    As many a cache needs to hold that reads no tile twice.
    """
    change = np.zeros(accessed.lookups + 1, np.int64)
    for first, last, tile in accessed.banks:
        _, begin, which = np.unique(tile, return_index=True, return_inverse=True)
        end = np.zeros(len(begin), np.int64)
        np.maximum.at(end, which, last)
        np.add.at(change, first[begin], 1)
        np.subtract.at(change, end + 1, 1)
    return int(np.cumsum(change).max(initial=0))
