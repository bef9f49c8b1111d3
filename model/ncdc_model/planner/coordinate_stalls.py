"""Delays by a front end that gives less than a group of pixels per clock."""

import numpy as np

from ncdc_model.planner.lookups import pieces
from ncdc_spec.nodes import AFTER, BEFORE

__all__ = ["coordinate_stalls"]


def coordinate_stalls(boxes, timing):
    """Earliest clocks at which look-ups enter the cache if coordinates are computed too slowly.

    With nodes, the first pixel after node k of a row needs node k + 2, and a node takes
    ``timing.node_clocks``; a row of W pixels has ceil(W / S) + 3 nodes. A network at every pixel
    gives a group of pixels in that many clocks.

    Parameters
    ----------
    boxes : Lookups
    timing : CorrectorTiming

    Returns
    -------
    list of (int, int)
        (look-up, delay): look-up i enters at clock i + delay or later, counted from the frame's
        first look-up. Steps ascend in both; there is none if each clock gives a group.
    """
    if timing.nodes == 1 and timing.node_clocks == 1:
        return []
    firsts = _groups(boxes) if timing.nodes == 1 else _segments(boxes, timing.nodes)
    found, highest = [], 0
    for first, needed in firsts:
        lookup = np.searchsorted(boxes.pixel, first.astype(boxes.pixel.dtype))
        delay = needed * timing.node_clocks - lookup
        until = np.maximum.accumulate(np.append(highest, delay))
        steps = np.flatnonzero(until[1:] > until[:-1])
        found += zip(lookup[steps].tolist(), delay[steps].tolist())
        highest = until[-1]
    return found


def _groups(boxes):
    """First pixels of all groups, and number of networks before each: a piece at a time."""
    for piece in pieces(-(-boxes.pixels // boxes.lanes)):
        number = np.arange(piece.start, piece.stop)
        yield number * boxes.lanes, number


def _segments(boxes, nodes):
    """First pixels of all segments between nodes, and number of nodes that they need in addition to
    those of the frame's first pixel: a piece at a time."""
    columns, rows = boxes.rows
    count = (-(-columns // nodes)).repeat(rows)         # for each row of each strip
    until, pixels = np.cumsum(count), columns.repeat(rows)
    left = np.cumsum(pixels) - pixels
    for piece in pieces(until[-1]):
        number = np.arange(piece.start, piece.stop)
        row = np.searchsorted(until, number, "right")
        segment = number - (until - count)[row]
        yield left[row] + segment * nodes, row * (BEFORE + AFTER) + number
