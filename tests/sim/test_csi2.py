"""The CSI-2 receiver's Verilog on the lanes of a transmitter that is written apart from it.

Frames with skew, gaps and short rests; each fault planted; corrupted packets by the thousand.
"""

import pytest

from csi2_frames import (
    FAULTS,
    check_corrupted,
    check_faulty,
    check_reset,
    check_statuses,
    check_whole,
    corrupted_frames,
    faulty_frames,
    header_frames,
    long_frames,
    odd_frames,
    received,
    reset_frames,
    residue_frames,
    whole_frames,
)
from ncdc_spec.sensors.csi2 import SAMPLE_BITS_OF, DataType


@pytest.mark.parametrize("lanes,count", [
    (2, 4), *(pytest.param(lanes, 4, marks=pytest.mark.longer) for lanes in (1, 4)),
    *(pytest.param(lanes, 100, marks=pytest.mark.regress) for lanes in (1, 2, 4))])
@pytest.mark.parametrize("kind", SAMPLE_BITS_OF, ids=lambda kind: kind.name)
def test_frames_are_received(lanes, count, kind):
    wire, frames = whole_frames(lanes, kind, count)
    check_whole(received(wire, kind), frames, kind)


# One lane has no skew, and four have a header at once.
NOT_OF = {("too much skew", 1), ("a header is cut", 4)}


@pytest.mark.parametrize("fault,lanes", [
    pytest.param(fault, lanes, marks=[pytest.mark.longer] * (lanes != 2))
    for fault in FAULTS for lanes in (1, 2, 4) if (fault, lanes) not in NOT_OF])
def test_each_fault_is_counted_and_the_next_frame_is_right(fault, lanes):
    wire, frames = faulty_frames(lanes, fault)
    check_faulty(received(wire, DataType.RAW10), fault, frames)


LANES = [2, *(pytest.param(lanes, marks=pytest.mark.longer) for lanes in (1, 4))]


@pytest.mark.parametrize("lanes", LANES)
def test_each_bit_and_pair_of_bits_of_a_header(lanes):
    wire, bad, faults = header_frames(lanes)
    check_statuses(received(wire, DataType.RAW10), bad, faults)


@pytest.mark.parametrize("lanes", LANES)
@pytest.mark.parametrize("kind", SAMPLE_BITS_OF, ids=lambda kind: kind.name)
def test_rows_of_any_number_of_bytes(lanes, kind):
    wire, bad, faults = odd_frames(lanes, kind)
    check_statuses(received(wire, kind), bad, faults)


@pytest.mark.parametrize("lanes", LANES)
def test_each_bit_that_a_wrong_checksum_leaves(lanes):
    wire, bad, faults = residue_frames(lanes)
    check_statuses(received(wire, DataType.RAW8), bad, faults)


@pytest.mark.longer
@pytest.mark.parametrize("lanes", [1, 2, 4])
def test_rows_of_up_to_65535_bytes(lanes):
    wire, frames = long_frames(lanes)
    check_whole(received(wire, DataType.RAW8), frames, DataType.RAW8)


def corrupted(lanes, count, seed=1):
    wire, frames, untouched = corrupted_frames(lanes, count, seed)
    check_corrupted(received(wire, DataType.RAW10), frames, untouched)


def test_corrupted_packets():
    corrupted(2, 300)


@pytest.mark.regress
@pytest.mark.many_clocks
@pytest.mark.parametrize("lanes", [1, 2, 4])
def test_a_hundred_thousand_corrupted_packets(lanes):
    for seed in range(10):
        corrupted(lanes, 10_000, seed)


@pytest.mark.parametrize("lanes", [
    2, *(pytest.param(lanes, marks=pytest.mark.longer) for lanes in (1, 4))])
def test_a_reset_at_any_clock(lanes):
    """The frame under way is forgotten, and the burst under way ignored; the next frame is
    right."""
    wire, frames, reset, whole = reset_frames(lanes)
    check_reset(received(wire, DataType.RAW10, reset=reset), frames, whole)
