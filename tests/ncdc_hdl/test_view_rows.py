"""Tables of matrices down the raw frame in the front end: equal to the golden model, always."""

from dataclasses import replace

import numpy as np
import pytest

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
    load_rows,
    prepare,
    words_of,
)
from ncdc_hdl.frontend.raw_rows import RawRows
from ncdc_hdl.frontend.row_matrices import RowMatrices
from ncdc_model.golden.view_rows import added, next_rows
from ncdc_spec.nodes import row_nodes
from ncdc_spec.view import View
from ncdc_spec.view_rows import ROW_SHIFT, STEPS, RowTable
from pipelines import run_bench
from views import nonsense_table, nonsense_view, turning_view

MATRICES = 6
SIZES = ((72, 10), (72, 8), (40, 12))


def at_nodes(nodes=8, size=(72, 40), neurons=4):
    return replace(barrel_descriptor(size, (80, 44), hidden_neurons=neurons), nodes=nodes)


def views(d, rng, sizes):
    """A view of each size with a table; in every third one both are nonsense, in every fourth one
    there is none."""
    cases = []
    for k, size in enumerate(sizes):
        view = turning_view(rng, d.geometry, 45, size, MATRICES, pan=50, roll=180, zoom=(.5, 4))
        if k % 3 == 2:
            view = replace(nonsense_view(rng, size), rows=nonsense_table(rng, MATRICES))
        cases.append(replace(view, rows=None) if k % 4 == 3 else view)
    return cases


@pytest.mark.parametrize("nodes,multiplier_bits", [(8, 27), (16, 18)])
def test_what_a_table_adds(nodes, multiplier_bits):
    rng, found = np.random.default_rng(nodes), []
    tables = [nonsense_table(rng, 64) for _ in range(6)]
    tables += [RowTable(step, tuple(map(tuple, rng.integers(-9999, 9999, (64, 9)).tolist())))
               for step in STEPS]
    dut = RowMatrices(nodes, 64, multiplier_bits)
    cases = [(table, rng.integers(-1, 516, 12), rng.integers(0, 4096, 12),
              rng.choice([0, 4095, *rng.integers(0, 700, 10)], 12)) for table in tables]

    async def bench(ctx):
        for bank, (table, number, line, row) in enumerate(cases):
            view = View.identity((72, 8))
            await load_rows(ctx, dut.rows, dut.writes, replace(view, rows=table), bank % 2)
            seen, at = [], []
            for k in range(len(number) + 8):
                for clock in range(6 + (k % 3)):
                    ctx.set(dut.issue, clock == 0)
                    if clock == 0 and k < len(number):
                        at.append(len(seen) + dut.latency)
                        ctx.set(dut.number, int(number[k]))
                        ctx.set(dut.line, int(line[k]))
                    ctx.set(dut.row, int(row[k]) if clock == 0 and k < len(number) else 77)
                    seen.append((await ctx.tick().sample(dut.o))[2])
            found.append([seen[k:k + 3] for k in at])

    run_bench(dut, bench)
    for (table, number, line, row), result in zip(cases, found):
        x, y, z = added(table, nodes * number, line, row) >> ROW_SHIFT
        np.testing.assert_array_equal(result, np.stack([z, x, y], axis=1))


def test_raw_rows_in_their_limits():
    q = at_nodes().network_formats.coordinate
    y = np.array([0, q.lo, q.hi, -1, (1 << q.f_bits - 1) - 1, 1 << q.f_bits - 1, -3 << q.f_bits - 1,
                  (4094 << q.f_bits) + (1 << q.f_bits - 1), 500 << q.f_bits])
    fits, found = np.arange(len(y)) != 8, []
    dut = RawRows(q, 8, 4)

    async def bench(ctx):
        await ctx.tick().repeat(dut.way)        # nothing has been issued before
        for value, fit in zip(y.tolist(), fits.tolist()):
            ctx.set(dut.y, value)
            ctx.set(dut.fits, fit)
            ctx.set(dut.arrive, 1)
            await ctx.tick()
        ctx.set(dut.arrive, 0)
        await ctx.tick().repeat(dut.latency)
        for _ in y:
            assert ctx.get(dut.ready)
            found.append(ctx.get(dut.row))
            ctx.set(dut.issue, 1)
            await ctx.tick()
            ctx.set(dut.issue, 0)
            await ctx.tick().repeat(3)
        assert not ctx.get(dut.ready)

    run_bench(dut, bench)
    np.testing.assert_array_equal(found, next_rows(y, fits, q))


@pytest.mark.longer
@pytest.mark.parametrize("nodes,strip,lanes,share,stall", [
    (8, 32, 1, 4, .4), *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (16, 0, 4, 2, .2),
        (8, 0, 1, 1, 0), (8, 64, 2, 3, .3), (16, 32, 4, 1, .6), (32, 0, 1, 7, .3)))])
def test_another_lens_and_table_with_every_frame(nodes, strip, lanes, share, stall):
    size = (max(72, 4 * nodes + 8), 40)
    d = at_nodes(nodes, size, max(4, share))
    other = replace(extreme(d, 2), valid=d.valid)
    cases = views(d, np.random.default_rng(nodes), [(w + size[0] - 72, h) for w, h in SIZES])
    dut = FrontEnd(d, lanes, share=share, view=True, view_rows=MATRICES)
    lenses = [d, other, d]
    for frame, lens, view in zip(frames(dut, lenses, stall, strip=strip, views=cases), lenses,
                                 cases):
        assert_equal(frame, expected(lens, strip, lanes, view))


@pytest.mark.regress
@pytest.mark.parametrize("seed", range(4))
def test_sixty_tables_and_nonsense(seed):
    d, rng = at_nodes(), np.random.default_rng(seed)
    cases = views(d, rng, [(40, 8)] * 60)
    dut = FrontEnd(d, share=2, view=True, view_rows=MATRICES)
    for frame, view in zip(frames(dut, [d] * 60, .1, views=cases), cases):
        assert_equal(frame, expected(d, 0, 1, view))


@pytest.mark.regress
def test_abort_at_any_moment():
    """An aborted frame is its beginning and a blank end; the next one, of another table, is whole.
    """
    d, rng = at_nodes(8), np.random.default_rng(3)
    cases = views(d, rng, [(72, 9)] * 5)
    dut = FrontEnd(d, share=3, view=True, view_rows=MATRICES)
    backmap, results = dut.backmap, []
    moments = [*rng.integers(1, 700, 2).tolist(), *rng.integers(1, 60, 2).tolist(), None]

    async def bench(ctx):
        await prepare(ctx, backmap, d)
        for k, (view, moment) in enumerate(zip(cases, moments)):
            load(ctx, backmap, d, 32, view)
            await load_rows(ctx, backmap.rows, backmap.row_writes, view, k % 2)
            await write_bank(ctx, backmap.writes, words_of(d))
            results.append(await aborted_frame(ctx, backmap, rng, moment, .8))

    run_bench(dut, bench)
    cuts = 0
    for (frame, cut), view in zip(results, cases):
        whole = expected(d, 32, 1, view)
        if not cut:
            assert_equal(frame, whole)
            continue
        cuts += 1
        assert_equal(frame[:-1], whole[:len(frame) - 1])
        assert (frame[-1:, 2:] == [1, len(frame) == 1, 1]).all()
    assert cuts >= 3 and not results[-1][1]


@pytest.mark.longer
def test_the_first_pixel_comes_after_its_row_has_settled():
    width, arrived = 168, []
    d = at_nodes(8, (width, 8), 2)
    dut = FrontEnd(d, share=2, view=True, view_rows=2)
    backmap = dut.backmap
    settling = backmap.settling(width)
    assert settling == 2 * 6 * row_nodes(width, 8)

    async def bench(ctx):
        await prepare(ctx, backmap, d)
        load(ctx, backmap, d, view=View.identity((width, 8)))
        ctx.set(backmap.o.ready, 1)
        ctx.set(backmap.start, 1)
        await ctx.tick()
        ctx.set(backmap.start, 0)
        while not arrived or not arrived[-1]:
            arrived.append((await ctx.tick().sample(backmap.o.valid))[2])

    run_bench(dut, bench)
    assert len(arrived) == settling + backmap.start_latency
