"""Window address: gateware compared with the golden model, over the image's edges."""

from dataclasses import replace

import numpy as np
import pytest

from ncdc_hdl.backend.window import WindowAddress
from ncdc_model.golden.picture import window_address
from ncdc_spec.descriptor import Formats
from ncdc_spec.geometry import Geometry
from ncdc_spec.interpolation import FAST, GRADIENT
from pipelines import get, put, run_bench

FORMATS = Formats()
Q = FORMATS.coordinate
G = Geometry(16, 16, 40, 24)


def points(rng):
    """Coordinates one unit around every half pixel near the image's edges."""
    half = 1 << (Q.f_bits - 1)
    edges = [[e * half + d for e in (*range(-4, 5), *range(2 * size - 8, 2 * size + 2))
              for d in (-1, 0, 1)] + [Q.lo, Q.hi] for size in G.distorted]
    corners = [(x, y) for x in edges[0] for y in edges[1]]
    return corners + rng.integers(-2048, 42 << Q.f_bits, (300, 2)).tolist()


def missing(first, size, needs):
    """How many columns, or rows, of a window are outside, and whether they are after."""
    outside = [k for k in range(first - needs.margin, first + needs.after + 1)
               if not 0 <= k < size]
    return len(outside), bool(outside and outside[0] > 0)


@pytest.mark.longer
@pytest.mark.parametrize("needs", [FAST, GRADIENT], ids=lambda each: each.name)
@pytest.mark.parametrize("gap,stall", [(.3, .7), *(
    pytest.param(*case, marks=pytest.mark.regress) for case in ((0, 0), (.5, 0), (0, .5)))])
def test_equals_model(needs, gap, stall):
    rng = np.random.default_rng(4)
    geometry = replace(G, interpolation=needs)
    items = [{"x": x, "y": y, "blank": int(rng.random() < .2), "first": k % 5 == 0,
              "last": k % 7 == 0} for k, (x, y) in enumerate(points(rng))]
    dut, got = WindowAddress(FORMATS, interpolation=needs), []

    async def source(ctx):
        ctx.set(dut.width, G.distorted_width)
        ctx.set(dut.height, G.distorted_height)
        await put(ctx, dut.i, items, lambda: rng.random() < gap)

    async def sink(ctx):
        got.extend(await get(ctx, dut.o, len(items), lambda: rng.random() < stall))

    run_bench(dut, source, sink)
    x, y = (np.array([item[name] for item in items]) for name in "xy")
    x0, y0, fx, fy, inside = window_address(x, y, geometry, Q)
    for k, (item, out) in enumerate(zip(items, got)):
        blank = item["blank"] or not inside[k]
        assert (out.blank, out.first, out.last) == (blank, item["first"], item["last"]), item
        if not blank:
            assert (out.x0, out.y0, out.fx, out.fy) == (x0[k], y0[k], fx[k], fy[k]), item
            for edge, first, size in ((out.edge_x, x0[k], G.distorted_width),
                                      (out.edge_y, y0[k], G.distorted_height)
                                      ) if needs.margin else ():
                count, after = missing(int(first), size, needs)
                assert edge.missing == count and (not count or edge.after == after), item
    assert 100 < inside.sum() < len(items) - 100


def test_edges_keep_their_pixels_and_beyond_is_blank():
    """A source on the edge's own samples is valid; one more than a pixel outside is not."""
    one = 1 << Q.f_bits
    for size, axis in ((G.distorted_width, 0), (G.distorted_height, 1)):
        for value, inside, origin in ((-one // 2 - 1, False, 0), (-one // 2, True, 0),
                                      (0, True, 0), (one // 2, True, 0), (one, True, 0),
                                      ((size - 1) * one, True, size - 3),
                                      ((size - 1) * one + one // 2 - 1, True, size - 3),
                                      ((size - 1) * one + one // 2, False, 0)):
            point = [5 * one, 5 * one]
            point[axis] = value
            result = window_address(*point, G, Q)
            assert result[4] == inside and (not inside or result[axis] == origin), (axis, value)
