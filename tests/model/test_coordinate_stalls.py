"""Look-ups that wait for the nodes around them, compared with a loop over all pixels."""

from dataclasses import replace

import numpy as np
import pytest

from ncdc_model.planner.coordinate_stalls import coordinate_stalls
from ncdc_model.planner.corrector_timing import CorrectorTiming
from ncdc_model.planner.lookups import Windows, lookups

TIMING = CorrectorTiming(*[0] * 15, nodes=8, node_clocks=2, lead=0)


def windows(width, height, apart):
    """Windows a column apart, and further where groups are to be cut."""
    x0 = np.tile(np.arange(width, dtype=np.int32), (height, 1))
    x0[:, ::12] += apart
    return Windows(x0, np.zeros_like(x0), np.ones(x0.shape, bool))


def entered(boxes, timing, strip, width, height):
    """Clock in which each look-up enters, look-up by look-up, if nothing else holds it up."""
    node, release = 0, {}               # nodes before the row; first pixel of a segment: clock
    pixel = 0
    for left in range(0, width, strip or width):
        columns = min(strip or width, width - left)
        for _ in range(height):
            for column in range(0, columns, timing.nodes):
                # Four nodes surround a segment; the frame's first one waits for nodes 0 to 3.
                last = node + column // timing.nodes + 3
                release[pixel + column] = timing.node_clocks * (last - 3)
            pixel += columns
            node += -(-columns // timing.nodes) + 3
    clocks, clock = [], -1
    for first in boxes.pixel.tolist():
        clock = max(clock + 1, release.get(first, 0))
        clocks.append(clock)
    return clocks


@pytest.mark.parametrize("nodes", [8, 16, 32])
@pytest.mark.parametrize("width,strip", [(48, 0), (76, 32), (200, 64)])
@pytest.mark.parametrize("lanes,node_clocks,apart", [(1, 2, 0), (4, 2, 0), (4, 2, 40), (2, 9, 0)])
def test_lags_are_those_of_a_loop(nodes, width, strip, lanes, node_clocks, apart):
    boxes = lookups(windows(width, 5, apart), strip, lanes)
    timing = replace(TIMING, nodes=nodes, node_clocks=node_clocks)
    steps = coordinate_stalls(boxes, timing)
    number = np.arange(len(boxes))
    at = np.array([-1, *(step[0] for step in steps)])
    lag = np.array([0, *(step[1] for step in steps)])
    assert (np.diff(lag) > 0).all() and (np.diff(at) > 0).all()
    clocks = number + lag[np.searchsorted(at, number, "right") - 1]
    assert clocks.tolist() == entered(boxes, timing, strip, width, 5)


def test_a_network_at_every_pixel_gives_a_group_in_so_many_clocks():
    boxes = lookups(windows(8, 2, 0), 0, 2)
    timing = replace(TIMING, nodes=1, node_clocks=3)
    assert coordinate_stalls(boxes, timing) == [(k, 2 * k) for k in range(1, 8)]
    assert coordinate_stalls(boxes, replace(timing, node_clocks=1)) == []


def test_nothing_waits_where_the_nodes_of_a_row_come_in_its_clocks():
    boxes = lookups(windows(320, 20, 0), 0, 1)
    assert coordinate_stalls(boxes, replace(TIMING, nodes=16, node_clocks=13)) == []
    assert coordinate_stalls(boxes, replace(TIMING, nodes=16, node_clocks=14)) != []
