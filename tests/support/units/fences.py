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
