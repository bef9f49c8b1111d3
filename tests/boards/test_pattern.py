"""The test pattern that stands for a sensor: its pins, its setup, and where it fits."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from board_bench import SMALL
from cameras import barrel_descriptor
from ncdc_boards.board import Request
from ncdc_boards.camera_board.design import SENSOR_CLOCK_HZ, design_of
from ncdc_boards.camera_board.pattern import PatternSensor, pattern_samples, pattern_sensor
from ncdc_boards.catalogue import board, board_names
from ncdc_boards.ulx3s.board import BOARD
from ncdc_hdl.registers.program import Op
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import Geometry
from ncdc_spec.sensors.framing import shown
from ncdc_spec.sensors.sensor import Timing


def sent(codes, timing):
    """Frames (rows of samples) at a pattern's pins in the clocks of three frames."""
    pattern, pins = PatternSensor(codes, timing), []
    simulator = Simulator(pattern)
    simulator.add_clock(1e-6)

    async def bench(ctx):
        for _ in range(3 * timing.frame_clocks):
            await ctx.tick()
            pins.append([ctx.get(getattr(pattern.pins, name))
                         for name in ("frame_valid", "line_valid", "data")])

    simulator.add_testbench(bench)
    simulator.run()
    frames, rows, before = [], [], (0, 0)
    for frame, line, sample in pins:
        if frame and not before[0]:
            rows = []
        if line:
            assert frame
            if not before[1]:
                rows.append([])
            rows[-1].append(sample)
        if before[0] and not frame:
            frames.append(rows)
        before = frame, line
    return frames


@pytest.mark.parametrize("size", [(10, 9), (16, 8), (9, 9)])
def test_each_frame_is_the_pattern(size):
    """Also of sizes whose codes do not fill words of the memory."""
    codes = np.random.default_rng(1).integers(0, 4, size[::-1], dtype=np.uint8)
    frames = sent(codes, Timing(*size, size[0] + 5, size[1] + 3, SENSOR_CLOCK_HZ))
    assert len(frames) >= 2
    for frame in frames:
        assert np.array_equal(frame, pattern_samples(codes))


def test_levels_span_all_samples():
    assert pattern_samples([0, 1, 2, 3]).tolist() == [0, 0x555, 0xAAA, 0xFFF]


@pytest.mark.parametrize("size", [(64, 48), (640, 480), (1280, 720)])
def test_it_is_a_sensor_of_25_frames_at_most_that_shows_all(size):
    geometry = Geometry(64, 48, *size, bayer="GBRG")
    setup, crop = pattern_sensor(geometry, SENSOR_CLOCK_HZ)
    assert 20 < setup.timing.frames_per_second <= 25
    assert setup.bayer == "GBRG" and shown(setup, crop, geometry) == (0, 0, *size)


def test_its_program_accesses_no_sensor():
    """No command goes to the I2C bus: nothing would answer."""
    lens = barrel_descriptor((64, 24), (64, 24), hidden_neurons=2)
    design = design_of(BOARD, [("a", lens)], pattern_sensor(lens.geometry, SENSOR_CLOCK_HZ), SMALL)
    registers = {r.name: r.address for r in design.system.table}
    steps = design.programs[0]
    assert registers["I2C_COMMAND"] not in [address for op, address, _ in steps if op == Op.WRITE]
    assert steps[-1] == (Op.WRITE, registers["CAMERA_ENABLE"], 1)


@pytest.mark.parametrize("name,request_,size,said", [
    ("de0-cv", {}, (64, 48), "pattern is not supported on the de0-cv: the ulx3s has it"),
    ("ulx3s", {"settings": {"field": "full"}}, (64, 48), "field of the sensor pattern cannot be"),
    ("ulx3s", {"processor": True}, (64, 48), "the board ulx3s has no Ethernet chip"),
    ("ulx3s", {}, (1280, 960), "takes 2457600 bits of block RAM, the ulx3s has 2097152 for it: raw "
     "frames of 1048576 pixels fit"),
])
def test_what_has_no_pattern_is_rejected_in_a_sentence(name, request_, size, said):
    lens = barrel_descriptor((64, 48), size, hidden_neurons=2)
    with pytest.raises(InputError, match=said):
        board(name).design([("a", lens)], Request("pattern", **request_),
                           lambda hardware, _: hardware)


def test_the_limit_leaves_block_ram_for_the_core():
    """Of the 208 blocks of 18 kbit, 16 kbit each at worst for a pattern, the whole board of
    docs/reference/ulx3s.md takes 61."""
    assert BOARD.pattern_bits // (16 << 10) + 61 < 208
    offered = [name for name in board_names() if getattr(board(name), "pattern_bits", 0)]
    assert offered == ["ulx3s"]
