"""The scan: normalised coordinates, blanking and frame marks of every pixel, bit for bit."""

import numpy as np
import pytest
from amaranth import *
from pipelines import run_bench

from ncdc_hdl.frontend.scan import Scan
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_model.descriptor import Formats
from ncdc_model.geometry import Geometry, ValidRows
from ncdc_model.network import normalised_scan


class Dut(Elaboratable):
    def __init__(self, valid, rows):
        self.scan, self.table = Scan(Formats()), ValidTable(valid, rows)

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan, m.submodules.table = scan, table = self.scan, self.table
        m.d.comb += [table.row.eq(scan.row), scan.spans.eq(table.spans), scan.fresh.eq(table.fresh)]
        return m


@pytest.mark.parametrize("size", [(8, 8), (37, 11), (64, 9)])
@pytest.mark.parametrize("pause,host", [(0, 0), (.4, 0), (0, .5), (.4, .8)])
def test_every_pixel_equals_model(size, pause, host):
    """``host``: how often the host takes the table's port, also just when a row ends."""
    (width, height), rng = size, np.random.default_rng(size[0])
    g, formats = Geometry(width, height, 40, 40), Formats()
    valid = ValidRows.of_mask(np.abs(np.indices((height, width))[1] - width // 2)
                              > np.arange(height)[:, None] // 2)
    dut, got = Dut(valid, height), []
    origin_x, step_x, origin_y, step_y = g.scan()

    async def bench(ctx):
        scan = dut.scan
        ctx.set(scan.parameters, {"width": width, "height": height, "origin_x": origin_x,
                                  "step_x": step_x, "origin_y": origin_y, "step_y": step_y})
        for _ in range(2):
            ctx.set(scan.start, 1)
            await ctx.tick()
            ctx.set(scan.start, 0)
            taken = 0
            while taken < width * height:
                ctx.set(dut.table.host_read, int(rng.random() < host))
                ctx.set(dut.table.host_row, int(rng.integers(height)))
                await ctx.delay(1e-10)
                advance = ctx.get(scan.active) and rng.random() >= pause
                ctx.set(scan.advance, int(advance))
                if advance:
                    got.append([ctx.get(s) for s in (scan.pixel.x, scan.pixel.y, scan.blank, scan.first,
                                                     scan.last)])
                    taken += 1
                await ctx.tick()
            ctx.set(scan.advance, 0)
            assert not ctx.get(scan.active)

    run_bench(dut, bench)
    v, u = (a.ravel() for a in np.indices((height, width)))
    x, y = normalised_scan(u, v, g, formats)
    count = width * height
    expected = np.stack([x, y, ~valid.mask(width).ravel(), np.arange(count) == 0,
                         np.arange(count) == count - 1], axis=1).astype(np.int64)
    np.testing.assert_array_equal(got, np.concatenate([expected, expected]))



def test_model_scan_is_symmetric_and_below_one():
    for width, height in ((8, 9), (640, 480), (1281, 1023), (4096, 4096)):
        g, formats = Geometry(width, height, 8, 8), Formats()
        x, y = g.normalise(np.arange(width), 0)[0], g.normalise(0, np.arange(height))[1]
        for axis in (x, y):
            np.testing.assert_array_equal(axis, -axis[::-1])
            assert 0.999 < axis[-1] <= 0.9999
        raw, _ = normalised_scan(np.arange(width), 0, g, formats)
        assert np.abs(formats.input.real(raw) - x).max() <= 2.0**-(formats.input.f_bits + 1)
