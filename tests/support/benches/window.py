"""Window address, transfer by transfer: that of ``ncdc_model.golden.picture.window_address``."""

import cocotb
import numpy as np

from benches.common import get, pack, put, settings, start, unpack
from ncdc_hdl.backend.layouts import request_layout
from ncdc_hdl.frontend.layouts import coordinate_layout
from ncdc_model.golden.picture import window_address
from ncdc_spec.descriptor import Formats
from ncdc_spec.geometry import Geometry

__all__ = ["equals_model"]

G = Geometry(16, 16, 40, 24)


@cocotb.test()
async def equals_model(dut):
    """One unit around every point where the window meets the image's edge, then random."""
    s, f, rng = settings(), Formats(), np.random.default_rng(4)
    q = f.coordinate
    half = 1 << (q.f_bits - 1)
    edges = [[(e << q.f_bits) + half + d for e in (-2, -1, 0, size - 3, size - 2, size - 1)
              for d in (-1, 0)] + [q.lo, q.hi] for size in G.distorted]
    points = [(x, y) for x in edges[0] for y in edges[1]]
    points += rng.integers(-2048, 42 << q.f_bits, (300, 2)).tolist()
    items = [{"x": x, "y": y, "blank": int(rng.random() < .2), "first": k % 5 == 0,
              "last": k % 7 == 0} for k, (x, y) in enumerate(points)]
    await start(dut, width=G.distorted_width, height=G.distorted_height, i__valid=0, o__ready=0)
    cocotb.start_soon(put(dut, "i", [pack(coordinate_layout(f), item) for item in items],
                          s["gap"]))
    got = await get(dut, "o", len(items), s["stall"])
    x, y = np.array(points).T
    x0, y0, fx, fy, inside = window_address(x, y, G, q)
    for k, (item, value) in enumerate(zip(items, got)):
        out = unpack(request_layout(q.f_bits), value)
        blank = int(item["blank"] or not inside[k])
        assert (out.blank, out.first, out.last) == (blank, item["first"], item["last"]), item
        if not blank:
            assert (out.x0, out.y0, out.fx, out.fy) == (x0[k], y0[k], fx[k], fy[k]), item
