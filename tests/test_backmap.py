"""Front end: coordinates in raster order equal the golden model, whatever the back end does."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from cameras import barrel_descriptor
from pipelines import get, run_bench

from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_model.network import frame_coordinates


class FrontEnd(Elaboratable):
    """Front end and table of valid rows, as the corrector joins them."""

    def __init__(self, d):
        self.backmap = BackMap(d.hidden_neurons, d.formats)
        self.table = ValidTable(d.valid, d.geometry.corrected_height)

    def elaborate(self, platform):
        m = Module()
        m.submodules.backmap, m.submodules.table = self.backmap, self.table
        m.d.comb += [self.table.row.eq(self.backmap.row), self.backmap.spans.eq(self.table.spans),
                     self.backmap.fresh.eq(self.table.fresh)]
        return m


def load(ctx, backmap, d):
    """Set the parameters of descriptor ``d``."""
    g = d.geometry
    origin_x, step_x, origin_y, step_y = g.scan()
    ctx.set(backmap.scan, {"width": g.corrected_width, "height": g.corrected_height,
                           "origin_x": origin_x, "step_x": step_x,
                           "origin_y": origin_y, "step_y": step_y})
    network = backmap.network
    for j in range(d.hidden_neurons):
        ctx.set(network.hidden[j], {"weights": d.hidden_weights[j].tolist(),
                                    "bias": int(d.hidden_biases[j])})
    for k in range(2):
        ctx.set(network.output[k], {"weights": d.output_weights[k].tolist(),
                                    "bias": int(d.output_biases[k])})


def expected(d):
    """(x, y, blank, first, last) of every pixel in raster order."""
    x, y = frame_coordinates(d)
    flags = np.zeros((2, x.size), int)
    flags[0, 0] = flags[1, -1] = 1
    blank = ~d.valid.mask(d.geometry.corrected_width)
    return np.stack([x.ravel(), y.ravel(), blank.ravel().astype(int), *flags], axis=1)


def fields(items):
    return np.array([[c.x, c.y, c.blank, c.first, c.last] for c in items])


@pytest.mark.parametrize("stall", [0, .3, .9])
def test_two_frames_equal_model(stall):
    d = barrel_descriptor((20, 16), (24, 18))
    dut, rng, results = FrontEnd(d), np.random.default_rng(5), []

    async def bench(ctx):
        load(ctx, dut.backmap, d)
        for _ in range(2):
            ctx.set(dut.backmap.start, 1)
            await ctx.tick()
            ctx.set(dut.backmap.start, 0)
            results.append(fields(await get(ctx, dut.backmap.o, 20 * 16,
                                            lambda: rng.random() < stall)))

    run_bench(dut, bench)
    for frame in results:
        np.testing.assert_array_equal(frame, expected(d))
    assert 0 < expected(d)[:, 2].sum() < 320


def test_one_coordinate_per_clock():
    d = barrel_descriptor((20, 16), (24, 18))
    dut, valid = FrontEnd(d), []

    async def bench(ctx):
        load(ctx, dut.backmap, d)
        ctx.set(dut.backmap.o.ready, 1)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        for _ in range(450):
            valid.append((await ctx.tick().sample(dut.backmap.o.valid))[2])

    run_bench(dut, bench)
    first = valid.index(1)
    assert sum(valid) == 320 and all(valid[first:first + 320]), "a clock without a coordinate"
    # After the start: table, network, queue.
    assert first == 1 + dut.backmap.latency + 2


def test_stops_and_restarts_without_losing_a_clock():
    d = barrel_descriptor((64, 16), (24, 18))
    dut = FrontEnd(d)
    idle, gaps = [], 0

    async def bench(ctx):
        nonlocal gaps
        load(ctx, dut.backmap, d)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        for _ in range(300):
            idle.append((await ctx.tick().sample(dut.backmap.idle))[2])
        ctx.set(dut.backmap.o.ready, 1)
        for _ in range(64 * 16):
            gaps += not (await ctx.tick().sample(dut.backmap.o.valid))[2]

    run_bench(dut, bench)
    assert idle[-1] and not idle[20], "the stalled front end must come to rest, the running not"
    assert gaps == 0


def test_host_may_read_the_table_while_scanning():
    d = barrel_descriptor((20, 16), (24, 18))
    dut, results = FrontEnd(d), []

    async def host(ctx):
        for row in range(16):
            for span in range(2):
                ctx.set(dut.table.host_row, row)
                ctx.set(dut.table.host_span, span)
                ctx.set(dut.table.host_read, 1)
                await ctx.tick()
                ctx.set(dut.table.host_read, 0)
                got = [ctx.get(dut.table.host_span_start), ctx.get(dut.table.host_span_stop)]
                assert got == d.valid.spans[row, 2 * span:2 * span + 2].tolist()
                await ctx.tick()

    async def bench(ctx):
        load(ctx, dut.backmap, d)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        results.append(fields(await get(ctx, dut.backmap.o, 320, lambda: False)))

    run_bench(dut, bench, host)
    np.testing.assert_array_equal(results[0], expected(d))


def test_refuses_a_short_queue():
    with pytest.raises(ValueError, match="queue is 100, it must exceed twice the latency 54"):
        BackMap(4, barrel_descriptor().formats, queue=100)
