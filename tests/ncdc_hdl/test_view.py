"""Views in the front end: nodes and pixels equal the golden model, always."""

from dataclasses import replace

import numpy as np
import pytest
from amaranth import *

from banks import write_bank
from cameras import barrel_descriptor
from front_end import (
    FrontEnd,
    aborted_frame,
    assert_equal,
    expected,
    extreme,
    frames,
    load,
    prepare,
    words_of,
)
from ncdc_hdl.frontend.node_scan import NodeScan
from ncdc_hdl.frontend.view_transform import ViewTransform
from ncdc_model.golden.view import homogeneous, node_positions
from ncdc_spec.nodes import row_nodes
from ncdc_spec.view import NODE, PLANE, View
from pipelines import run_bench
from views import nonsense_view, random_view

SIZES = ((72, 10), (72, 8), (40, 12))


def at_nodes(nodes=8, size=(72, 40), neurons=4):
    return replace(barrel_descriptor(size, (80, 44), hidden_neurons=neurons), nodes=nodes)


def views(d, rng, sizes):
    """A view of each size, every third one nonsense."""
    return [nonsense_view(rng, size) if k % 3 == 2 else
            random_view(rng, d.geometry, 45, size, pan=50, roll=180, zoom=(.5, 4))
            for k, size in enumerate(sizes)]


def overflowing(size):
    """Views whose numerators, positions and normalised coordinates overflow, into the picture if
    that were not noticed."""
    deep, flat = 1 << 23, 1 << 30           # depths 2**-7 and 1
    small, one = 1 << 20, 1 << 27           # steps that are a pixel at these depths
    return [View((small, 0, 256 << 17, 0, small, 0, 0, 0, deep), size),
            View((one, 0, 16380 << 17, 0, one, 0, 0, 0, flat), size),
            View((one, 0, 144 << 17, 0, one, 0, 0, 0, flat), size)]


class Nodes(Elaboratable):
    """The scan of nodes and the view after it."""

    def __init__(self, d, interval, multiplier_bits):
        formats = d.network_formats
        self.scan = NodeScan(formats, d.nodes, interval, view=True)
        self.transform = ViewTransform(formats.input, d.nodes, interval, multiplier_bits)

    def elaborate(self, platform):
        m = Module()
        m.submodules.scan, m.submodules.transform = scan, transform = self.scan, self.transform
        m.d.comb += [transform.start.eq(scan.start), transform.parameters.eq(scan.parameters),
                     transform.i_issue.eq(scan.issue), transform.i_whole.eq(scan.whole),
                     transform.edges.eq(scan.edges)]
        return m


def nodes_of(d, size, strip):
    """Columns and rows of the nodes of a picture of ``size`` in the order of the scan."""
    width, height = size
    found = []
    for left in range(0, width, strip or width):
        columns = left + d.nodes * np.arange(-1, row_nodes(min(strip or width, width - left),
                                                           d.nodes) - 1)
        found += [(u, v) for v in range(height) for u in columns]
    return np.array(found).T


@pytest.mark.parametrize("interval,strip,multiplier_bits", [
    (3, 32, 27),
    *(pytest.param(*case, marks=pytest.mark.longer) for case in ((4, 0, 18), (7, 32, 27)))])
def test_nodes_equal_the_golden_model(interval, strip, multiplier_bits):
    d, rng, results = at_nodes(), np.random.default_rng(interval), []
    cases = [*views(d, rng, SIZES), *overflowing((72, 8))]
    dut = Nodes(d, interval, multiplier_bits)
    scan, transform = dut.scan, dut.transform
    origin_x, step_x, origin_y, step_y = d.geometry.scan()

    async def bench(ctx):
        for view in cases:
            ctx.set(scan.parameters, {
                "width": view.size[0], "height": view.size[1], "strip": strip,
                "origin_x": origin_x, "step_x": step_x, "origin_y": origin_y, "step_y": step_y})
            ctx.set(transform.view, {"matrix": np.reshape(view.matrix, (3, 3)).tolist(),
                                     "plane_height": 40})
            ctx.set(scan.start, 1)
            await ctx.tick()
            ctx.set(scan.start, 0)
            count, found, places = len(nodes_of(d, view.size, strip)[0]), [], []
            scanned, issued = [], []
            while len(found) < count:
                ctx.set(scan.space, rng.random() < .8)
                *_, issues, total, issue, x, y, fits, column, row = await ctx.tick().sample(
                    transform.scan.issue, transform.scan.o, transform.issue, transform.x,
                    transform.y, transform.fits, transform.column, transform.row)
                scanned.append(total)
                issued.append(issues)
                places.append((column, row))
                if issue:
                    found.append((x, y, fits, *places[-1 - transform.early]))
            await ctx.tick().repeat(interval)
            sums = np.array([scanned[k:k + 3] for k in np.flatnonzero(issued)])
            results.append((sums, np.array(found)))

    run_bench(dut, bench)
    fitting = 0
    for view, (sums, result) in zip(cases, results):
        x, y, depth = homogeneous(view, *nodes_of(d, view.size, strip))
        np.testing.assert_array_equal(sums, np.stack([depth, x, y], axis=1))
        positions, inputs, fits = node_positions(d, view, *nodes_of(d, view.size, strip))
        np.testing.assert_array_equal(result[:, 2], fits)
        wanted = np.stack([*inputs, *(p >> PLANE.f_bits - NODE.f_bits for p in positions)], axis=1)
        np.testing.assert_array_equal(result[fits][:, [0, 1, 3, 4]], wanted[fits])
        fitting += fits.sum()
    assert fitting > 100
    assert not any(result[:, 2].any() for _, result in results[-3:-1])


@pytest.mark.longer
@pytest.mark.parametrize("nodes,strip,lanes,share,stall", [
    (8, 32, 1, 4, .4), (16, 0, 4, 2, .2),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (8, 0, 1, 1, 0), (8, 64, 2, 3, .3), (16, 32, 4, 1, .6), (32, 0, 1, 4, .3)))])
def test_another_lens_and_view_with_every_frame(nodes, strip, lanes, share, stall):
    size = (max(72, 4 * nodes + 8), 40)
    d = at_nodes(nodes, size)
    other = replace(extreme(d, 2), valid=d.valid)
    cases = views(d, np.random.default_rng(nodes), [(w + size[0] - 72, h) for w, h in SIZES])
    cases += [View.identity((size[0], 8))]
    dut, lenses = FrontEnd(d, lanes, share=share, view=True), [d, other, d, d]
    for frame, lens, view in zip(frames(dut, lenses, stall, strip=strip, views=cases), lenses,
                                 cases):
        assert_equal(frame, expected(lens, strip, lanes, view))


@pytest.mark.regress
@pytest.mark.parametrize("seed", range(4))
def test_sixty_views_and_nonsense(seed):
    d, rng = at_nodes(), np.random.default_rng(seed)
    cases = views(d, rng, [(40, 8)] * 60)
    dut = FrontEnd(d, share=2, view=True)
    for frame, view in zip(frames(dut, [d] * 60, .1, views=cases), cases):
        assert_equal(frame, expected(d, 0, 1, view))


@pytest.mark.longer
@pytest.mark.parametrize("lanes,strip", [(1, 32), pytest.param(4, 0, marks=pytest.mark.regress)])
def test_abort_at_any_moment(lanes, strip):
    """An aborted frame is its beginning and a blank end; the next one, of another view, is whole.
    """
    d, rng = at_nodes(8), np.random.default_rng(lanes)
    cases = views(d, rng, [(72, 9)] * 8)
    dut = FrontEnd(d, lanes, share=3, view=True)
    backmap, results = dut.backmap, []
    moments = [*rng.integers(1, 500, 3).tolist(), *rng.integers(1, 60, 4).tolist(), None]

    async def bench(ctx):
        await prepare(ctx, backmap, d)
        for view, moment in zip(cases, moments):
            load(ctx, backmap, d, strip, view)
            await write_bank(ctx, backmap.writes, words_of(d))
            results.append(await aborted_frame(ctx, backmap, rng, moment, .8))

    run_bench(dut, bench)
    cuts = 0
    for (frame, cut), view in zip(results, cases):
        whole = expected(d, strip, lanes, view)
        if not cut:
            assert_equal(frame, whole)
            continue
        cuts += 1
        assert_equal(frame[:-lanes], whole[:len(frame) - lanes])
        assert (frame[-lanes:, 2:] == [1, len(frame) == lanes, 1]).all()
    assert cuts >= 4 and not results[-1][1]


@pytest.mark.longer
def test_the_first_pixel_comes_after_the_start_latency():
    d, valid = at_nodes(8, (72, 40)), []
    dut = FrontEnd(d, share=4, view=True)

    async def bench(ctx):
        await prepare(ctx, dut.backmap, d)
        load(ctx, dut.backmap, d, view=View.identity((72, 8)))
        ctx.set(dut.backmap.o.ready, 1)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        for _ in range(72 * 8 + 300):
            valid.append((await ctx.tick().sample(dut.backmap.o.valid))[2])

    run_bench(dut, bench)
    arrived = np.flatnonzero(valid)
    assert len(arrived) == 72 * 8
    assert arrived[0] + 1 == dut.backmap.start_latency
