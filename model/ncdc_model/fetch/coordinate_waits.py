"""How far the front end of a corrector falls behind a group of pixels per clock."""

import numpy as np

from ncdc_model.nodes import BEFORE, BEHIND

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
    if timing.nodes == 1:
        firsts = np.arange(0, boxes.pixels, boxes.lanes) if timing.node_clocks > 1 else np.arange(0)
        needed = np.arange(firsts.size)
    else:
        columns, rows = boxes.rows
        segments = -(-columns // timing.nodes)
        count = segments.repeat(rows)       # of each row of each strip
        row = np.arange(count.size).repeat(count)
        segment = np.arange(row.size) - (np.cumsum(count) - count)[row]
        pixels = columns.repeat(rows)
        firsts = (np.cumsum(pixels) - pixels)[row] + segment * timing.nodes
        needed = row * (BEFORE + BEHIND) + np.arange(row.size)
    lookup = np.searchsorted(boxes.pixel, firsts)
    lag = needed * timing.node_clocks - lookup
    highest = np.maximum.accumulate(np.append(0, lag))
    steps = np.flatnonzero(highest[1:] > highest[:-1])
    return list(zip(lookup[steps].tolist(), lag[steps].tolist()))
