"""Sources of the stream of samples: a parallel sensor's pins, AXI4-Stream and Avalon-ST video."""

import numpy as np
import pytest

from ncdc_hdl.camera.avalon_st_source import AvalonStSource
from ncdc_hdl.camera.axis_source import AxisSource
from ncdc_hdl.camera.parallel_source import ParallelSource
from ncdc_spec.camera_port import SAMPLE_BITS, SAMPLES_PER_CLOCK, CameraPort, camera_port
from ncdc_spec.errors import InputError
from pipelines import run_bench
from units.videos import Sink, check_avalon_st_video, check_axis_video, check_control_packets


def pins_of(rng, frame, close):
    """(FRAME_VALID, LINE_VALID) and sample of each clock; ``close``: both fall together, and a
    single clock lies between two frames."""
    clocks = [(1, 0, 5)] * (0 if close else rng.integers(0, 4))
    for y, row in enumerate(frame):
        clocks += [(1, 1, int(sample)) for sample in row]
        clocks += [(1, 0, 7)] * (0 if close and y == len(frame) - 1 else rng.integers(1, 4))
    return clocks + [(0, int(rng.integers(2)), 9)] * (1 if close else rng.integers(1, 9))


def test_parallel_pins():
    """Rows of one sample and more, pauses of every length; a frame under way at first is none."""
    dut, rng = ParallelSource(), np.random.default_rng(1)
    frames = [rng.integers(0, 4096, (1 + number % 3, 1 + number % 4)) for number in range(24)]
    sink = Sink(dut.o)

    async def bench(ctx):
        clocks = [(1, 1, 3)] * 4 + [(1, 0, 3)] + [(0, 0, 3)]
        for number, frame in enumerate(frames):
            clocks += pins_of(rng, frame, number % 2)
        for frame, line, sample in [*clocks, *[(1, 0, 1)] * 3, *[(0, 1, 1)] * 4]:
            ctx.set(dut.pins.frame_valid, frame)
            ctx.set(dut.pins.line_valid, line)
            ctx.set(dut.pins.data, sample)
            await ctx.tick()
            sink.look(ctx)

    run_bench(dut, bench)
    assert sink.ended == [frame.tolist() for frame in frames] and len(sink.frames) == len(frames)


def forms(form):
    """One form of beats, and all others as longer tests."""
    return pytest.mark.parametrize("count,bits", [form, *(
        pytest.param(count, bits, marks=pytest.mark.longer)
        for count in SAMPLES_PER_CLOCK for bits in SAMPLE_BITS if (count, bits) != form)])


@forms((2, 10))
def test_axis_video(count, bits):
    check_axis_video(AxisSource(count, bits), count, bits)


@forms((4, 12))
def test_avalon_st_video(count, bits):
    check_avalon_st_video(AvalonStSource(count, bits), count, bits)


@forms((2, 8))
def test_avalon_st_video_with_control_packets(count, bits):
    check_control_packets(AvalonStSource(count, bits, control=True), count, bits)


@pytest.mark.parametrize("options,message", [
    (("axis", 3), "samples per clock is 3, it must be one of 1, 2, 4"),
    (("axis", 2, 14), "bits per sample is 14, it must be one of 8, 10, 12, 16"),
    (("parallel", 2), "a parallel camera has 1 sample per clock, not 2"),
    (("csi2:2", 4), "csi2:2 has 2 samples per clock, not 4"),
    (("csi2:2", 2, 10), "of the kind csi2 has samples of 12 bits, not 10"),
    (("csi2:3",), "--camera is csi2:3, it must be parallel, axis, avalon-st, avalon-st:vip, csi2"),
    (("csi2",), "--camera is csi2, it must be"), (("usb",), "--camera is usb, it must be")])
def test_cameras_that_are_not_supported(options, message):
    with pytest.raises(InputError, match=message):
        camera_port(*options)


def test_cameras_that_are_supported():
    assert camera_port("csi2:4") == CameraPort("csi2", 4)
    assert camera_port("avalon-st:vip", 2, 8) == CameraPort("avalon-st:vip", 2, 8)
    assert camera_port("csi2:4").options == ["--camera csi2:4"]
