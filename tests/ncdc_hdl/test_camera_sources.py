"""Sources of the stream of samples: a parallel sensor's pins, AXI4-Stream video."""

import numpy as np
import pytest

from ncdc_hdl.camera.axis_source import COUNTS, AxisSource
from ncdc_hdl.camera.parallel_source import ParallelSource
from ncdc_spec.errors import InputError
from pipelines import run_bench


class Sink:
    """Gathers the frames of a stream, as lists of rows, and checks its rules."""

    def __init__(self, stream):
        self.stream, self.frames, self.under_way = stream, [], False

    def look(self, ctx):
        """Take what the stream gives in this clock."""
        o = self.stream
        valid, first, last, end = (ctx.get(signal) for signal in (o.valid, o.first, o.last, o.end))
        if first:
            self.frames.append({"rows": [[]], "ended": False})
            self.under_way = True
        if valid:
            assert self.under_way
            self.frames[-1]["rows"][-1] += [ctx.get(o.sample[k]) for k in range(len(o.sample))
                                            if valid >> k & 1]
        else:
            assert not first and not last
        if last:
            self.frames[-1]["rows"].append([])
        if end:
            assert self.under_way and not ctx.get(o.bad)
            self.under_way, self.frames[-1]["ended"] = False, True

    @property
    def ended(self):
        """Rows of the frames that ended."""
        return [frame["rows"][:-1] for frame in self.frames if frame["ended"]]


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


def beats_of(frame, count, bits):
    """(TDATA, TUSER, TLAST) of the beats of a frame."""
    for y, row in enumerate(frame):
        for x in range(0, len(row), count):
            yield (sum(int(sample) << bits * k for k, sample in enumerate(row[x:x + count])),
                   x == y == 0, x + count == len(row))


@pytest.mark.parametrize("count,bits", [(2, 10), *(
    pytest.param(count, bits, marks=pytest.mark.longer)
    for count in COUNTS for bits in (8, 10, 12, 16) if (count, bits) != (2, 10))])
def test_axis_video(count, bits):
    """Beats with gaps or without; short frames are reported and have no end, rows outside of a
    frame are reported and dropped; the next frame is right."""
    dut, rng, height = AxisSource(count, bits), np.random.default_rng(count * bits), 3
    heights = [3, 3, 2, 3, 5, 3, 1, 1, 3]
    frames = [rng.integers(0, 1 << bits, (rows, count * 4)) for rows in heights]
    sink, short, stray = Sink(dut.o), 0, 0

    async def bench(ctx):
        nonlocal short, stray
        ctx.set(dut.height, height)
        # Rows before the first frame.
        beats = [(1, 0, 0), (1, 0, 1)]
        for frame in frames:
            beats += beats_of(frame, count, bits)
        for beat in [*beats, *[None] * 3]:
            gap = rng.integers(0, 3) if rng.integers(2) else 0
            for now in [*[None] * gap, beat]:
                data, first, last = now or (rng.integers(0, 1 << 8), *rng.integers(0, 2, 2))
                ctx.set(dut.tvalid, now is not None)
                ctx.set(dut.tdata, int(data))
                ctx.set(dut.tuser, int(first))
                ctx.set(dut.tlast, int(last))
                assert ctx.get(dut.tready)
                await ctx.tick()
                sink.look(ctx)
                short += ctx.get(dut.short)
                stray += ctx.get(dut.stray)

    run_bench(dut, bench)
    upper = [frame[:height] << 12 >> bits for frame in frames if len(frame) >= height]
    assert sink.ended == [frame.tolist() for frame in upper]
    assert (short, stray) == (3, 1 + 2)


@pytest.mark.parametrize("count,bits,message", [
    (3, 10, "has 1, 2 or 4 samples per clock, not 3"),
    (2, 14, "has 8, 10, 12 or 16 bits per sample, not 14")])
def test_video_that_is_not_supported(count, bits, message):
    with pytest.raises(InputError, match=message):
        AxisSource(count, bits)
