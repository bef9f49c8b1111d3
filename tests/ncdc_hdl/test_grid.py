"""The grid stage: gateware equals the golden model, in every pattern of clocks and with faults."""

from itertools import product

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.camera.grid import Grid
from ncdc_hdl.camera.moved import Moved
from ncdc_hdl.camera.parallel_source import ParallelSource
from ncdc_hdl.camera.samples import FRAME_GAP
from ncdc_hdl.system import System
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.grid import evened, grid_size, gridded
from ncdc_spec.sensors.level import levelled
from pipelines import run_pipeline
from sensor_ports import CLEAN, Port, SamplesPort, pins_of, random_frames

MODES = [(0, 0), (3, 0), (2, 1), (0, 1)]        # weight and binning
FAST, SLOW = (0, 1, 0), (3, 7, 5)               # see `pins_of`


def test_moved_equals_model():
    rng = np.random.default_rng(1)
    lines = np.concatenate([rng.integers(0, 4096, (400, 9)), 4095 * rng.integers(0, 2, (400, 9)),
                            np.zeros((1, 9), int), np.full((1, 9), 4095)])
    items = [(line, odd, weight) for line in lines for odd in (0, 1) for weight in range(4)]
    dut = Moved()

    def drive(ctx, item):
        line, odd, weight = item
        # The middle one is that of index 4 or 5, the newest first.
        ctx.set(dut.taps, [int(value) for value in line[2 + odd:7 + odd][::-1]])
        ctx.set(dut.odd, odd)
        ctx.set(dut.weight, weight)

    found = run_pipeline(dut, items, drive, lambda: [dut.o])
    # Rows that are all the same do not move along columns.
    moved = {weight: [evened(np.tile(line, (5, 1)), weight)[2] for line in lines]
             for weight in range(4)}
    wanted = [moved[weight][k][4 + odd] for k in range(len(lines)) for odd in (0, 1)
              for weight in range(4)]
    assert np.array_equal(np.ravel(found), wanted)


def whole(port, samples):
    """The window of a frame as the golden model has it."""
    (left, top), (width, height) = port.corner, port.window
    return levelled(gridded(samples, *port.mode))[top:top + height, left:left + width].tolist()


@pytest.mark.parametrize("size,mode", [
    *(pytest.param(*case, marks=pytest.mark.longer)
      for case in (((22, 12), (3, 0)), ((27, 15), (2, 1)))),
    ((13, 9), (0, 1)), ((13, 9), (0, 0)),
    *(pytest.param(size, mode, marks=pytest.mark.regress)
      for size in ((24, 12), (29, 13), (27, 14), (30, 15)) for mode in MODES)])
def test_equals_model_in_every_pattern_of_clocks(size, mode):
    """Each frame with other pauses; the window is all that there is, and then its inside."""
    all_of_it = grid_size(size, *mode)
    inside = tuple(length - 3 for length in all_of_it)
    pauses = list(product((0, 3), (1, 2, 9), (0, 1)))
    frames = random_frames(size, len(pauses))
    clocks = [clock for frame, each in zip(frames, pauses) for clock in pins_of(frame, each)]
    for corner, window in (((0, 0), all_of_it), ((2, 1), inside)):
        port = Port(size, window, corner, mode)
        found = port.run(clocks)
        assert len(found) == len(frames)
        for frame, (rows, report) in zip(frames, found):
            assert report == CLEAN and rows == whole(port, frame)


@pytest.mark.parametrize("mode", MODES)
def test_rows_may_follow_each_other_without_a_clock_between(mode):
    """As those of a video stream do; a parallel sensor's rows have a pause."""
    size = 27, 15
    frames = random_frames(size, 2)
    port = SamplesPort(1, size, grid_size(size, *mode), (0, 0), mode)
    clocks = []
    for frame in frames:
        for y, row in enumerate(frame):
            for x, sample in enumerate(row):
                ends = x == size[0] - 1
                clocks.append(([int(sample)], x == y == 0, ends, ends and y == size[1] - 1, 0))
        clocks += [port.REST] * FRAME_GAP
    assert port.run(clocks) == [(whole(port, frame), CLEAN) for frame in frames]


def short(y, row):
    return row[:-1] if y == 5 else row


def long(y, row):
    return [*row, 77] if y == 1 else row


def glitch(y, row):
    return [*row[:9], None, *row[10:]] if y == 6 else row


FAULTS = {"short": ("lines", {"change": short}, 12), "long": ("lines", {"change": long}, 12),
          "glitch": ("lines", {"change": glitch}, 12), "cut": ("rows", {}, 11),
          "two rows": ("rows", {}, 2), "one row": ("rows", {}, 1), "more rows": ("rows", {}, 14)}


@pytest.mark.parametrize("mode", MODES)
@pytest.mark.parametrize("fault", FAULTS)
def test_each_fault_is_reported_and_the_next_frame_is_right(fault, mode):
    name, how, height = FAULTS[fault]
    size = 24, 12
    port = Port(size, grid_size(size, *mode), (0, 0), mode)
    frames = [random_frames((24, rows), 1, k)[0] for k, rows in enumerate((12, height, 12))]
    clocks = [*pins_of(frames[0], FAST), *pins_of(frames[1], SLOW, **how),
              *pins_of(frames[2], FAST)]
    found = port.run(clocks)
    assert [report[name] > 0 for _, report in found] == [False, True, False]
    assert [rows == whole(port, frame) for frame, (rows, _) in zip(frames, found)][::2] == [1, 1]


@pytest.mark.parametrize("mode", MODES)
def test_a_row_longer_than_the_stage_holds_is_a_fault(mode):
    size = 24, 12
    frame = random_frames(size, 1)[0]
    for row, lines in ((24, 0), (23, 12 * any(mode))):
        found, = Port(size, (4, 2), (0, 0), mode, row).run(pins_of(frame, FAST))
        assert found[1] == CLEAN | {"lines": lines}


@pytest.mark.parametrize("mode", MODES)
def test_reset_in_mid_row(mode):
    """At any clock of a row: the frame under way is forgotten, and the next one is right."""
    size = 24, 12
    frames = random_frames(size, 2)
    first = pins_of(frames[0], FAST)
    clocks = [*first, *pins_of(frames[1], FAST)]
    for at in (1, 152, len(first) - 3):
        port = Port(size, grid_size(size, *mode), (0, 0), mode)
        found = port.run(clocks, [(at, "reset", 1), (at + 1, "reset", 0)])
        assert found == [(whole(port, frames[1]), CLEAN)], at


def test_a_queue_that_is_full_is_reported():
    size, mode = (24, 12), (3, 0)
    frames = random_frames(size, 2)
    port = Port(size, grid_size(size, *mode), (0, 0), mode)
    clocks = [*pins_of(frames[0], FAST), *pins_of(frames[1], SLOW)]
    found = port.run(clocks, [(160, "space", 0), (170, "space", 1)])
    assert [report["overflow"] for _, report in found] == [1, 0]
    assert found[1][0] == whole(port, frames[1])


def test_a_frame_that_began_before_enable_is_not_captured():
    """Its first samples came when the settings were free."""
    size, mode = (24, 12), (3, 1)
    frames = random_frames(size, 2)
    first = pins_of(frames[0], FAST)
    comes = ParallelSource.latency      # clock in which the port sees the first sample
    for at in (0, comes, comes + 1, 7, Grid.latency + 4):
        port = Port(size, grid_size(size, *mode), (0, 0), mode)
        found = port.run([*first, *pins_of(frames[1], FAST)], [(at, "enable", 1)], enable=0)
        wanted = [whole(port, frame) for frame in frames[at > comes:]]
        assert [rows for rows, _ in found] == wanted, at


@pytest.mark.parametrize("width", [5, 8, 26])
def test_latency_is_that_of_the_samples(width):
    """A sample leaves with the clock of its position, and with no weight as it came."""
    dut, items = Grid(width), list(np.random.default_rng(3).integers(0, 4096, 3 * width))

    def drive(ctx, item):
        ctx.set(dut.i.frame, 1)
        ctx.set(dut.i.valid, 1)
        ctx.set(dut.i.sample, int(item))

    found = run_pipeline(dut, items, drive, lambda: [dut.o.valid, dut.o.sample])
    assert found == [(1, item) for item in items]


@pytest.mark.parametrize("row", [7, MAX_SIZE + 1])
def test_a_stage_for_rows_that_no_frame_has_is_not_made(row):
    with pytest.raises(InputError, match=f"has {row} samples, it must have 8 to {MAX_SIZE}"):
        System(barrel_descriptor((64, 24), (64, 24)), Hardware(data_width=64), grid=row)
