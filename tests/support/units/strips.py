"""The order of the pixels, of pictures and strips of any size."""

import numpy as np

from pipelines import run_bench

__all__ = ["check_strips"]


def _groups(width, height, strip):
    """(column, last of its row, in the last row, in the last strip) of each pixel."""
    for left in range(0, width, strip or width):
        right = min(left + (strip or width), width)
        for row in range(height):
            for u in range(left, right):
                yield u, u == right - 1, row == height - 1, right == width


def check_strips(dut, orders, pauses):
    """All pixels of pictures, one after the other.

    Parameters
    ----------
    dut : ncdc_hdl.frontend.strips.Strips
        Of one lane.
    orders : sequence of (int, int, int)
        Width, height, and width of the strips.
    pauses : sequence of float
        How often no pixel follows the one before, in each of them.
    """
    rng, found = np.random.default_rng(2), []

    async def bench(ctx):
        for (width, height, strip), pause in zip(orders, pauses, strict=True):
            ctx.set(dut.order, {"width": width, "height": height, "strip": strip})
            ctx.set(dut.start, 1)
            await ctx.tick()
            ctx.set(dut.start, 0)
            while not ctx.get(dut.begin):
                await ctx.tick()
            pixels = []
            for _ in range(width * height):
                ctx.set(dut.advance, 1)
                await ctx.tick()
                ctx.set(dut.advance, 0)
                pixels.append(tuple(map(ctx.get, (dut.u, dut.last_column, dut.last_row,
                                                  dut.last_strip))))
                while rng.random() < pause:
                    await ctx.tick()
            found.append(pixels)
            assert ctx.get(dut.strip) == strip and ctx.get(dut.raster) == (strip == 0)

    run_bench(dut, bench)
    for order, pixels in zip(orders, found):
        assert pixels == [tuple(map(int, one)) for one in _groups(*order)], order
