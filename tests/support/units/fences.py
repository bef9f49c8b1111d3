"""Read commands at the edges of their area, and anywhere else."""

import numpy as np

from pipelines import get, put, run_bench

__all__ = ["check_read_fence"]


def _commands(rng, dut, base, limit, count):
    """Commands that begin near the area's edges, a power of two away from them, or anywhere."""
    word = 1 << dut.word_bits
    for k in range(count):
        edge = (base, limit)[int(rng.integers(2))]
        at = (edge + word * int(rng.integers(-6, 6)), edge + (1 << int(rng.integers(2, 32))),
              edge - (1 << int(rng.integers(2, 32))), int(rng.integers(1 << 32)))[k % 4]
        yield {"address": at % (1 << 32) // word * word, "words": int(rng.choice(dut.sizes))}


def _edges(rng, dut, count):
    """(base, limit) of areas that are empty, hold one command of the largest size, or nearly so."""
    word, largest = 1 << dut.word_bits, max(dut.sizes)
    for k in range(count):
        base = int(rng.integers(1 << 32))
        far = rng.choice([-1, 1]) * (1 << int(rng.integers(dut.word_bits, 32))) * (k % 3 == 2)
        limit = base + word * (largest + int(rng.integers(-2, 3))) + int(far)
        if 0 <= limit < 1 << 32:
            yield base, limit


async def _check_empty(ctx, dut, edges):
    """Whether each area is reported as one in which no largest command fits."""
    for base, limit in edges:
        ctx.set(dut.base, base)
        ctx.set(dut.limit, limit)
        await ctx.tick().repeat(2)
        first, end = base >> dut.word_bits, limit >> dut.word_bits
        assert ctx.get(dut.empty) == (first + max(dut.sizes) > end), (base, limit)


def check_read_fence(dut, areas=24, count=60):
    """Commands inside pass, others are moved to the area's begin, and reported.

    ``dut``: a :class:`ncdc_hdl.avalon.read_fence.ReadFence`; ``count``: commands of each area.
    """
    rng, word = np.random.default_rng(9), 1 << dut.word_bits
    cases, got, moved = [], [], []
    for k in range(areas):
        base, length = (int(rng.integers(1 << 32)) >> int(rng.integers(12)) * (k % 2),
                        int(rng.integers(16 * word, 1 << int(rng.integers(10, 31)))))
        limit = min(base + length, (1 << 32) - 1)
        cases.append((base, limit, list(_commands(rng, dut, base, limit, count))))

    async def source(ctx):
        await _check_empty(ctx, dut, _edges(np.random.default_rng(8), dut, 600))
        for k, (base, limit, commands) in enumerate(cases):
            while len(got) < k * count:
                await ctx.tick()
            ctx.set(dut.base, base)
            ctx.set(dut.limit, limit)
            await ctx.tick().repeat(2)
            assert not ctx.get(dut.empty)
            await put(ctx, dut.i, commands, lambda: rng.random() < .3)

    async def sink(ctx):
        while len(got) < areas * count:
            got.extend(await get(ctx, dut.o, 1, lambda: rng.random() < .3))

    async def watch(ctx):
        while True:
            moved.append((await ctx.tick().sample(dut.moved))[2])

    run_bench(dut, source, sink, background=(watch,))
    expected, outside = [], 0
    for base, limit, commands in cases:
        first, end = base // word, limit // word
        for one in commands:
            number = one["address"] // word
            inside = first <= number and number + one["words"] <= end
            outside += not inside
            expected.append((word * (number if inside else first), one["words"]))
    assert [(one.address, one.words) for one in got] == expected
    assert sum(moved) == outside and areas * count // 10 < outside < areas * count * 9 // 10
