"""The sensor's side of capture with 1, 2 and 4 samples per clock: windows, faults, a full queue."""

from itertools import product

import numpy as np
import pytest

from ncdc_hdl.camera.sensor_port import SensorPort
from ncdc_spec.errors import InputError
from ncdc_spec.raw_gains import sample_gains
from ncdc_spec.sensors.level import levelled
from sensor_ports import CLEAN, SamplesPort, random_frames, samples_of

COUNTS = 1, 2, 4
SLOW = [pytest.param(1, marks=pytest.mark.longer), pytest.param(2, marks=pytest.mark.longer), 4]
SENT = 23, 6            # a partial clock at the end of each row
GAINS = 512, 256, 397
# Corner and size: the whole frame, odd offsets, windows of few samples, at the edges.
WINDOWS = [((0, 0), SENT), *(((left, 1), (13, 4)) for left in range(8)),
           ((3, 2), (2, 2)), ((7, 0), (5, 6)), ((2, 1), (21, 5)), ((19, 3), (4, 3))]


def whole(port, frame, gains=(256, 256, 256)):
    """The window of a frame as the golden model has it."""
    (left, top), (width, height) = port.corner, port.window
    return levelled(frame[top:top + height, left:left + width],
                    gains=sample_gains(port.window, (0, 0), gains)).tolist()


@pytest.mark.parametrize("count", SLOW)
def test_windows_at_any_offset(count):
    rng = np.random.default_rng(count)
    for corner, window in WINDOWS:
        port = SamplesPort(count, SENT, window, corner,
                           balance={"gains": list(GAINS), "phase": 0})
        frames = random_frames(SENT, 3, count)
        clocks = [clock for frame in frames for clock in samples_of(frame, count, rng)]
        assert port.run(clocks) == [(whole(port, frame, GAINS), CLEAN) for frame in frames], corner


@pytest.mark.parametrize("count", COUNTS)
def test_rows_without_gaps(count):
    """Rows follow each other, and frames after as few clocks as they may."""
    class Never:
        @staticmethod
        def integers(most):
            return 0
    for left, width in product(range(4), (18, 19)):
        port = SamplesPort(count, SENT, (width, SENT[1]), (left, 0))
        frames = random_frames(SENT, 3, left)
        clocks = [clock for frame in frames for clock in samples_of(frame, count, Never)]
        assert port.run(clocks) == [(whole(port, frame), CLEAN) for frame in frames], left


def short(y, row):
    return row[:-1] if y == 3 else row


def long(y, row):
    return [*row, 77, 78] if y == 1 else row


def split(y, row):
    return row[:8] if y == 2 else row


def joined(y, row):
    return [*row, None] if y == 4 else row


FAULTS = {  # report, arguments of `samples_of`, rows
    "short": ({"lines": 1}, {"change": short}, 6), "long": ({"lines": 1}, {"change": long}, 6),
    "split": ({"lines": 1}, {"change": split}, 6),
    "joined": ({"lines": 1, "rows": 1}, {"change": joined}, 6),
    "cut": ({"rows": 1}, {}, 5), "one row": ({"rows": 1}, {}, 1), "more rows": ({"rows": 1}, {}, 8),
    "source": ({"bad": 1}, {"end": (1, 1)}, 6)}


@pytest.mark.parametrize("count", COUNTS)
@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_reported_and_the_next_frame_is_right(fault, count):
    wrong, how, height = FAULTS[fault]
    rng = np.random.default_rng(count)
    for corner, window in (WINDOWS[0], WINDOWS[4]):
        port = SamplesPort(count, SENT, window, corner)
        frames = [random_frames((SENT[0], rows), 1, rows)[0] for rows in (6, height, 6)]
        clocks = [clock for frame, options in zip(frames, ({}, how, {}))
                  for clock in samples_of(frame, count, rng, **options)]
        first, bad, last = port.run(clocks)
        assert bad[1] == CLEAN | wrong
        assert [first, last] == [(whole(port, frame), CLEAN) for frame in frames[::2]]


@pytest.mark.parametrize("count", COUNTS)
def test_a_frame_without_an_end(count):
    """It is bad; the frame whose beginning shows that is missed, and the one after it is right."""
    rng = np.random.default_rng(count)
    port = SamplesPort(count, SENT, *WINDOWS[4][::-1])
    frames = random_frames(SENT, 4)
    clocks = [clock for frame, end in zip(frames, ((1, 0), (0, 0), (1, 0), (1, 0)))
              for clock in samples_of(frame, count, rng, end=end)]
    first, bad, last = port.run(clocks)
    assert first == (whole(port, frames[0]), CLEAN) and bad[1]["bad"]
    assert last == (whole(port, frames[3]), CLEAN | {"missed": 1})


@pytest.mark.parametrize("count", SLOW)
def test_a_full_queue(count):
    """Full for four clocks at any time: a frame is whole, or has the report, or is missed."""
    rng, seen, sent = np.random.default_rng(count), set(), (11, 2)
    frames = random_frames(sent, 3)
    clocks = [clock for frame in frames for clock in samples_of(frame, count, rng)]
    for at in range(count == 1, len(clocks) * 2 // 3, 1 + (count == 1)):
        port = SamplesPort(count, sent, (8, 2), (3, 0))
        found = port.run(clocks, [(at, "space", 0), (at + 4, "space", 1)])
        missed = found[-1][1]["missed"]
        assert len(found) + missed == 3
        clean = [rows for rows, report in found if report == CLEAN | {"missed": report["missed"]}]
        others = [report for _, report in found if report["overflow"]]
        assert len(clean) + len(others) == len(found)
        right = [whole(port, frame) for frame in frames]
        assert all(rows in right for rows in clean) and found[-1][0] == right[-1]
        seen |= {("missed", missed), ("overflow", len(others))}
    assert seen >= {("missed", 1), ("overflow", 1), ("missed", 0), ("overflow", 0)}


def test_the_grid_stage_takes_one_sample_per_clock():
    with pytest.raises(InputError, match="takes 1 sample per clock, the camera has 4"):
        SensorPort(4, grid=80)
