"""The window of a coordinate, over the edges of frames of any size."""

import numpy as np

from ncdc_model.golden.picture import window_address
from ncdc_spec.geometry import Geometry
from pipelines import get, put, run_bench

__all__ = ["check_window_address"]


def _points(size, q, rng, count):
    """Coordinates one unit around every half pixel near the frame's edges, and any others."""
    half = 1 << (q.f_bits - 1)
    edges = [[e * half + d for e in (*range(-4, 5), *range(2 * side - 8, 2 * side + 2))
              for d in (-1, 0, 1)] + [q.lo, q.hi] for side in size]
    corners = [(x, y) for x in edges[0] for y in edges[1]]
    chosen = rng.permutation(corners)[:count]
    inner = rng.integers((0, 0), np.array(size) << q.f_bits, (count // 4, 2))
    far = rng.integers(q.lo, q.hi, (count // 8, 2))
    powers = np.stack([sign * (1 << rng.integers(0, q.width, count // 8)) for sign in (-1, 1)], 1)
    return rng.permutation(np.concatenate([chosen, inner, far, powers])).clip(q.lo, q.hi).tolist()


def _missing(first, size, needs):
    """How many columns, or rows, of a window are outside, and whether they are after."""
    outside = [k for k in range(first - needs.margin, first + needs.after + 1)
               if not 0 <= k < size]
    return len(outside), bool(outside and outside[0] > 0)


def check_window_address(dut, sizes, pauses, count=5000):
    """Compare with the golden model.

    Parameters
    ----------
    dut : ncdc_hdl.backend.window.WindowAddress
    sizes : sequence of (int, int)
        Of the raw frames, one after the other.
    pauses : sequence of (float, float)
        How often the source pauses, and the sink, in each of them.
    count : int
        Points near the edges, at most; half as many others.
    """
    rng, frames = np.random.default_rng(4), []
    for size in sizes:
        points = _points(size, dut.q, rng, count)
        frames.append([{"x": x, "y": y, "blank": int(rng.random() < .2), "first": k % 5 == 0,
                        "last": k % 7 == 0} for k, (x, y) in enumerate(points)])
    got = []

    async def source(ctx):
        for (width, height), items, (gap, _), k in zip(sizes, frames, pauses, range(len(sizes))):
            while len(got) < k:
                await ctx.tick()
            ctx.set(dut.width, width)
            ctx.set(dut.height, height)
            await ctx.tick()
            await put(ctx, dut.i, items, lambda gap=gap: rng.random() < gap)

    async def sink(ctx):
        for items, (_, stall) in zip(frames, pauses):
            got.append(await get(ctx, dut.o, len(items), lambda stall=stall: rng.random() < stall))

    run_bench(dut, source, sink)
    for size, items, found in zip(sizes, frames, got):
        _compare(dut, size, items, found)


def _compare(dut, size, items, found):
    """Compare the windows ``found`` of a frame with those of the golden model."""
    needs = dut.interpolation
    geometry = Geometry(16, 16, *size, interpolation=needs)
    x, y = (np.array([item[name] for item in items]) for name in "xy")
    x0, y0, fx, fy, inside = window_address(x, y, geometry, dut.q)
    for k, (item, out) in enumerate(zip(items, found)):
        blank = item["blank"] or not inside[k]
        assert (out.blank, out.first, out.last) == (blank, item["first"], item["last"]), item
        if not blank:
            assert (out.x0, out.y0, out.fx, out.fy) == (x0[k], y0[k], fx[k], fy[k]), item
            for edge, first, side in ((out.edge_x, x0[k], size[0]), (out.edge_y, y0[k], size[1])
                                      ) if needs.margin else ():
                outside, after = _missing(int(first), side, needs)
                assert edge.missing == outside and (not outside or edge.after == after), item
    assert len(items) // 20 < inside.sum() < len(items) * 19 // 20
