"""One sample per clock of several: order, flags, a full queue."""

import numpy as np
import pytest

from ncdc_hdl.camera.serializer import Serializer
from pipelines import run_bench

COUNTS = pytest.mark.parametrize("count", [1, 2, 4])


def sent(count, rows, pause, rng):
    """Clocks of a frame: (valid, samples, first, last, end, bad), with gaps, a pause after rows."""
    clocks = []
    for y, row in enumerate(rows):
        groups = [row[k:k + count] for k in range(0, len(row), count)]
        for k, group in enumerate(groups):
            clocks.append(((1 << len(group)) - 1, [*group, *[0] * (count - len(group))],
                           y == 0 and k == 0, k == len(groups) - 1, 0, 0))
            if rng.integers(4) == 0:
                clocks.append((0, [0] * count, 0, 0, 0, 0))
        clocks += [(0, [0] * count, 0, 0, 0, 0)] * pause
    return clocks


def given(dut, clocks, more):
    """What leaves: (sample or None, first, last, end, bad) of each clock in which anything does."""
    out = []

    async def bench(ctx):
        for valid, values, first, last, end, bad in [
                *clocks, *[(0, [0] * dut.count, 0, 0, 0, 0)] * more]:
            ctx.set(dut.i.valid, valid)
            for k, value in enumerate(values):
                ctx.set(dut.i.sample[k], int(value))
            for name, value in (("first", first), ("last", last), ("end", end), ("bad", bad)):
                ctx.set(getattr(dut.i, name), int(value))
            await ctx.tick()
            seen = [ctx.get(getattr(dut.o, name)) for name in ("first", "last", "end", "bad")]
            if ctx.get(dut.o.valid) or any(seen):
                out.append((ctx.get(dut.o.sample[0]) if ctx.get(dut.o.valid) else None, *seen))

    run_bench(dut, bench)
    return out


@COUNTS
@pytest.mark.parametrize("bad", [0, 1])
def test_samples_in_their_order_with_their_flags(count, bad):
    rng = np.random.default_rng(count)
    frames = [rng.integers(0, 4096, (3, width)) for width in (21, 8)]
    clocks, expected = [], []
    for rows in frames:
        clocks += [*sent(count, rows, 30, rng), (0, [0] * count, 0, 0, 1, bad)]
        for y, row in enumerate(rows):
            expected += [(int(value), int(y == 0 and x == 0), int(x == len(row) - 1), 0, 0)
                         for x, value in enumerate(row)]
        expected.append((None, 0, 0, 1, bad))
    assert given(Serializer(count, depth=16), clocks, 40) == expected


def test_an_end_with_the_last_samples_leaves_with_them():
    assert given(Serializer(2, depth=4), [(3, [1, 2], 1, 1, 1, 0)], 5) == [
        (1, 1, 0, 0, 0), (2, 0, 1, 1, 0)]


def test_a_full_queue_makes_the_frame_bad_and_the_next_is_right():
    rng = np.random.default_rng(1)
    long, short = rng.integers(0, 4096, (1, 200)), rng.integers(0, 4096, (1, 8))
    clocks = []
    for rows in (long, short):
        clocks += [*sent(4, rows, 60, rng), (0, [0] * 4, 0, 0, 1, 0)]
    out = given(Serializer(4, depth=8), clocks, 40)
    ends = [one for one in out if one[3]]
    assert [one[4] for one in ends] == [1, 0]
    assert [one[0] for one in out[-9:-1]] == list(short[0])
