"""Writes of a camera next to those of a corrected frame: address, time, and prediction."""

from fractions import Fraction
from itertools import islice

import pytest

from ncdc_model.planner.camera_writes import CameraWrites
from ncdc_model.planner.delay_steps import DelaySteps
from ncdc_model.planner.memory_timing import LatencyMemory
from ncdc_model.planner.ports import memory_port
from ncdc_model.planner.writes import FrameWrites

# Two rows of 12 samples, two clocks each, in lines of 40 clocks and frames of 100.
SMALL = CameraWrites(base=1000, pitch=16, width=12, height=2, sample=Fraction(2),
                     line=Fraction(40), frame=Fraction(100), burst=2, latency=3)


def test_accesses_worked_out_by_hand():
    """The frame before ends at 0, its rows were sent from -64 and -24 on: the next ones come at 36
    and 76. A burst of eight bytes is complete 16 clocks later, the rest of a row after 24."""
    found = list(islice(SMALL.accesses(word=4, block=4), 7))
    assert found == [(36 + 16 + 3 + 1, 1000, 1), (36 + 16 + 3 + 2, 1004, 1), (64, 1008, 1),
                     (96, 1016, 1), (97, 1020, 1), (104, 1024, 1), (156, 1000, 1)]


def test_accesses_do_not_leave_their_block():
    accesses = list(islice(SMALL.accesses(word=4, block=16), 3))
    assert accesses == [(57, 1000, 2), (64, 1008, 1), (97, 1016, 2)]


@pytest.mark.parametrize("camera", [False, True])
def test_a_read_waits_for_what_the_camera_has_written_before(camera):
    """A memory of a word per clock has the first read word at edge 4, or 5 if a camera's four words
    take the edges 1 to 4."""
    writes = FrameWrites(others=(lambda: iter([(0, 64 * k, 1) for k in range(4)])) if camera
                         else None)
    memory = LatencyMemory((1, 1), 4.0)
    port = memory_port(memory, 32, writes, DelaySteps(0))
    _, last = port.read(3, 4096, 4)
    assert last == (8 if camera else 7)
