"""How far the front end of a corrector falls behind a group of pixels per clock."""

import numpy as np

from ncdc_model.planner.lookups import pieces
from ncdc_spec.nodes import BEFORE, BEHIND

__all__ = ["coordinate_lags"]


def coordinate_lags(boxes, timing):
    """When look-ups enter the cache at the earliest, because of coordinates that come too slowly.

    At nodes, the first pixel after node k of a row needs node k + 2, and a node takes
    ``timing.node_clocks``: a row of W pixels has ceil(W / S) + 3 of them. A network at every pixel
    gives a group of pixels in so many clocks.

    Parameters
    ----------
    boxes : Lookups
    timing : CorrectorTiming

    Returns
    -------
    list of (int, int)
        (look-up, lag): look-up i enters lag clocks after clock i, counted from the frame's first
        look-up. Only steps, which ascend in both; none if a group comes in each clock.
    """
    if timing.nodes == 1 and timing.node_clocks == 1:
        return []
    firsts = _groups(boxes) if timing.nodes == 1 else _segments(boxes, timing.nodes)
    found, highest = [], 0
    for first, needed in firsts:
        lookup = np.searchsorted(boxes.pixel, first.astype(boxes.pixel.dtype))
        lag = needed * timing.node_clocks - lookup
        until = np.maximum.accumulate(np.append(highest, lag))
        steps = np.flatnonzero(until[1:] > until[:-1])
        found += zip(lookup[steps].tolist(), lag[steps].tolist())
        highest = until[-1]
    return found


def _groups(boxes):
    """First pixels of all groups, and how many networks come before: a piece at a time."""
    for piece in pieces(-(-boxes.pixels // boxes.lanes)):
        number = np.arange(piece.start, piece.stop)
        yield number * boxes.lanes, number


def _segments(boxes, nodes):
    """First pixels of all segments between nodes, and how many nodes more than for the frame's
    first pixel they need: a piece at a time."""
    columns, rows = boxes.rows
    count = (-(-columns // nodes)).repeat(rows)         # of each row of each strip
    until, pixels = np.cumsum(count), columns.repeat(rows)
    left = np.cumsum(pixels) - pixels
    for piece in pieces(until[-1]):
        number = np.arange(piece.start, piece.stop)
        row = np.searchsorted(until, number, "right")
        segment = number - (until - count)[row]
        yield left[row] + segment * nodes, row * (BEFORE + BEHIND) + number
