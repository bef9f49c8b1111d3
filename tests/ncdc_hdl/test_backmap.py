"""Front end: coordinates in the scan's order equal the golden model, whatever the back end does."""

import numpy as np
import pytest
from amaranth import *

from cameras import barrel_descriptor
from front_end import (
    FrontEnd,
    aborted_frame,
    expected,
    extreme,
    fields,
    frames,
    load,
    prepare,
)
from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.frontend.scan import Scan
from ncdc_hdl.frontend.valid import ValidTable
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from pipelines import get, run_bench

# Products of their own, and a raster of sums; one unit for each neuron in `make regress`.
EITHER_WAY = [("multiply", 3), pytest.param("raster", 2, marks=pytest.mark.longer), *(
    pytest.param(hidden, 1, marks=pytest.mark.regress) for hidden in ("multiply", "raster"))]


@pytest.mark.parametrize("hidden,share,stall", [
    ("multiply", 1, .3), ("raster", 3, .6),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        ("multiply", 1, 0), ("multiply", 2, .3), ("raster", 1, .7), ("multiply", 1, .9),
        ("multiply", 3, 0), ("raster", 1, 0), ("raster", 2, .3)))])
def test_two_frames_equal_model(hidden, share, stall):
    d = barrel_descriptor((16, 12), (24, 18))
    dut = FrontEnd(d, hidden=hidden, share=share)
    # A frame is longer than all that may be under way: the queue fills, and is emptied.
    assert 16 * 12 > dut.backmap.under_way + 16
    for frame in frames(dut, [d, d], stall):
        np.testing.assert_array_equal(frame, expected(d))
    assert 0 < expected(d)[:, 2].sum() < 16 * 12


@pytest.mark.longer
@pytest.mark.parametrize("hidden,share,strip,lanes,stall", [
    ("raster", 2, 32, 1, .3), ("multiply", 2, 32, 2, .6),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        ("multiply", 1, 32, 1, .3), ("raster", 2, 0, 4, 0), ("raster", 1, 32, 1, 0),
        ("multiply", 1, 0, 2, 0), ("raster", 1, 32, 2, .3)))])
def test_strips_and_lanes(hidden, share, strip, lanes, stall):
    d = barrel_descriptor((36, 8), (40, 18))
    dut = FrontEnd(d, lanes, hidden=hidden, share=share)
    for frame in frames(dut, [d, d], stall, strip=strip):
        np.testing.assert_array_equal(frame, expected(d, strip, lanes))


@pytest.mark.parametrize("hidden,share", EITHER_WAY)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.regress)])
def test_abort_at_any_moment(hidden, share, seed):
    """What comes out of an aborted frame is its beginning and a blank end; the next is whole."""
    d, rng = barrel_descriptor((44, 10), (40, 18)), np.random.default_rng(seed)
    dut, strip = FrontEnd(d, hidden=hidden, share=share), 32
    backmap, results = dut.backmap, []

    async def bench(ctx):
        await prepare(ctx, backmap, d)
        load(ctx, backmap, d, strip)
        for moment in (int(rng.integers(1, 500)), int(rng.integers(1, 60)), None):
            results.append(await aborted_frame(ctx, backmap, rng, moment, .5))

    run_bench(dut, bench)
    whole = expected(d, strip)
    assert results[1][1]
    for frame, cut in (result for result in results[:2] if result[1]):
        np.testing.assert_array_equal(frame[:-1], whole[:len(frame) - 1])
        assert frame[-1, 2:].tolist() == [1, len(frame) == 1, 1]
    for frame, cut in (result for result in results if not result[1]):
        np.testing.assert_array_equal(frame, whole)
    assert not results[2][1]


@pytest.mark.parametrize("hidden,share,neurons", [
    ("multiply", 1, 1), ("raster", 4, 5),
    pytest.param("multiply", 32, 32, marks=pytest.mark.longer),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        ("raster", 1, 1), ("multiply", 4, 5), ("multiply", 8, 8), ("multiply", 1, 32),
        ("raster", 1, 32), ("raster", 12, 32)))])
def test_any_number_of_neurons(hidden, share, neurons):
    d = barrel_descriptor((10, 9), (12, 10), hidden_neurons=neurons)
    frame, = frames(FrontEnd(d, hidden=hidden, share=share), [d], 0)
    np.testing.assert_array_equal(frame, expected(d))


@pytest.mark.longer
@pytest.mark.parametrize("hidden,share", EITHER_WAY)
def test_weights_at_the_limits_and_changed_between_frames(hidden, share):
    d = barrel_descriptor((12, 9), (12, 10), hidden_neurons=5)
    cases = [extreme(d, 1), d, extreme(d, 2), extreme(d, 3)]
    for frame, case in zip(frames(FrontEnd(d, hidden=hidden, share=share), cases, 0), cases):
        np.testing.assert_array_equal(frame, expected(case))
    q = d.formats.coordinate
    assert {q.lo, q.hi} <= set(np.ravel([expected(case)[:, :2] for case in cases]).tolist())


@pytest.mark.parametrize("hidden,share", EITHER_WAY)
def test_one_coordinate_every_share_clocks(hidden, share):
    d = barrel_descriptor((20, 16), (24, 18))
    dut, valid = FrontEnd(d, hidden=hidden, share=share), []

    async def bench(ctx):
        await prepare(ctx, dut.backmap, d)
        load(ctx, dut.backmap, d)
        ctx.set(dut.backmap.o.ready, 1)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        for _ in range(320 * share + 400):
            valid.append((await ctx.tick().sample(dut.backmap.o.valid))[2])

    run_bench(dut, bench)
    # After the start: scan, first sums of the frame, network, queue.
    preset = dut.backmap.hidden[0].control.preset if hidden == "raster" else 0
    first = Scan.latency + preset + dut.backmap.latency + 4 - 1
    expected_clocks = range(first, first + 320 * share, share)
    np.testing.assert_array_equal(np.flatnonzero(valid), expected_clocks)


@pytest.mark.longer
def test_stops_and_restarts_without_losing_a_clock():
    d = barrel_descriptor((64, 16), (24, 18))
    dut = FrontEnd(d)
    idle, gaps = [], []

    async def bench(ctx):
        await prepare(ctx, dut.backmap, d)
        load(ctx, dut.backmap, d)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        for _ in range(500):
            idle.append((await ctx.tick().sample(dut.backmap.idle))[2])
        ctx.set(dut.backmap.o.ready, 1)
        for _ in range(64 * 16):
            gaps.append(not (await ctx.tick().sample(dut.backmap.o.valid))[2])

    run_bench(dut, bench)
    latency = dut.backmap.latency
    begun = idle.index(0)
    full = idle.index(1, begun)
    # Before the frame, at rest; while pixels enter and are under way, not; when stalled, again.
    assert begun and all(idle[full:]) and full > 64 + latency
    assert len(gaps) == 64 * 16 and not any(gaps)


def test_host_may_read_the_table_while_scanning():
    d = barrel_descriptor((20, 16), (24, 18))
    dut, results = FrontEnd(d), []

    async def host(ctx):
        for row in range(16):
            for span in range(2):
                ctx.set(dut.table.host.row, row)
                ctx.set(dut.table.host.span, span)
                ctx.set(dut.table.host.read, 1)
                await ctx.tick()
                ctx.set(dut.table.host.read, 0)
                await ctx.tick().repeat(ValidTable.latency - 1)
                got = [ctx.get(dut.table.host.read_start), ctx.get(dut.table.host.read_stop)]
                assert got == d.valid.spans[row, 2 * span:2 * span + 2].tolist()

    async def bench(ctx):
        await prepare(ctx, dut.backmap, d)
        load(ctx, dut.backmap, d)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        results.append(fields(await get(ctx, dut.backmap.o, 320, lambda: False)))

    run_bench(dut, bench, host)
    np.testing.assert_array_equal(results[0], expected(d))


@pytest.mark.longer
@pytest.mark.parametrize("hidden,share", EITHER_WAY)
def test_products_in_parts(hidden, share):
    """The same coordinates, 3 clocks later for each layer that has products."""
    d = barrel_descriptor((20, 16), (24, 18))
    dut = FrontEnd(d, hidden=hidden, share=share, multiplier_bits=18)
    whole = FrontEnd(d, hidden=hidden, share=share)
    assert dut.backmap.latency - whole.backmap.latency == (3 if hidden == "raster" else 6)
    cases = [extreme(d, 1), d]
    for frame, case in zip(frames(dut, cases, .5), cases):
        np.testing.assert_array_equal(frame, expected(case))


def test_rejects_a_short_queue():
    formats = barrel_descriptor().formats
    under_way = BackMap(4, formats).under_way
    limit = under_way + 16
    BackMap(4, formats, queue=limit)
    with pytest.raises(ValueError, match=f"queue is {limit - 1}, the limit is {limit}: the "
                                         f"{under_way} groups under way and 16"):
        BackMap(4, formats, queue=limit - 1)


def test_rejects_sharing_among_more_neurons_than_there_are():
    with pytest.raises(InputError,
                       match="share is 5, the limit is the number of hidden neurons, 4"):
        BackMap(4, barrel_descriptor().formats, hardware=Hardware(share=5))


def test_rejects_unknown_options():
    with pytest.raises(InputError, match="hidden is 'add', one of multiply, raster is needed"):
        Hardware(hidden="add")
    with pytest.raises(InputError, match="share is 0, the least is 1"):
        Hardware(share=0)
    with pytest.raises(InputError, match="multiplier bits is 9, one of 27, 18 is needed"):
        Hardware(multiplier_bits=9)
