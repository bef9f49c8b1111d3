"""The front end with the network at nodes: coordinates equal the golden model, always."""

from dataclasses import replace

import numpy as np
import pytest

from banks import write_bank, write_word
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
    words_of,
)
from pipelines import get, run_bench


def at_nodes(nodes, size=(72, 10), neurons=4):
    return replace(barrel_descriptor(size, (80, 18), hidden_neurons=neurons), nodes=nodes)


@pytest.mark.longer
@pytest.mark.parametrize("nodes,width,strip,lanes,share,stall", [
    (8, 37, 0, 1, 2, .7), (16, 65, 0, 1, 3, .3), (16, 72, 32, 4, 2, .3),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (8, 72, 0, 1, 1, 0), (8, 72, 32, 1, 2, .3), (16, 66, 0, 2, 1, .3), (8, 72, 0, 4, 1, 0),
        (8, 72, 0, 1, 4, .3), (16, 72, 0, 1, 4, 0), (32, 130, 0, 1, 4, .3), (16, 97, 32, 1, 4, 0),
        (32, 130, 64, 1, 3, .6), (8, 72, 0, 2, 2, 0), (32, 132, 32, 4, 4, .6),
        (8, 36, 32, 4, 1, .9)))])
def test_two_frames_equal_model(nodes, width, strip, lanes, share, stall):
    d = at_nodes(nodes, (width, 10))
    dut = FrontEnd(d, lanes, share=share)
    for frame in frames(dut, [d, d], stall, strip=strip):
        np.testing.assert_array_equal(frame, expected(d, strip, lanes))
    assert 0 < expected(d)[:, 2].sum() < 10 * width


@pytest.mark.longer
@pytest.mark.parametrize("nodes,lanes,strip", [
    (16, 2, 32),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (32, 1, 0), (8, 1, 32), (8, 4, 0)))])
@pytest.mark.parametrize("seed", [1, *(pytest.param(n, marks=pytest.mark.regress) for n in (2, 3))])
def test_abort_at_any_moment(nodes, lanes, strip, seed):
    """What comes out of an aborted frame is its beginning and a blank end; the next is whole.

    The next frame begins at once, while nodes of the aborted one are in the network, with other
    weights: none of those nodes may be used.
    """
    d = at_nodes(nodes, (136, 9))
    other = replace(d, output_weights=-d.output_weights[:, ::-1].copy())
    rng = np.random.default_rng(seed)
    dut = FrontEnd(d, lanes, share=3)
    backmap, results = dut.backmap, []
    moments = [*rng.integers(1, 800, 3).tolist(), *rng.integers(1, 60, 4).tolist(), None]

    async def bench(ctx):
        await prepare(ctx, backmap, d)
        for number, moment in enumerate(moments):
            load(ctx, backmap, (d, other)[number % 2], strip)
            words = words_of((other, d)[number % 2])    # of the next frame, while this one runs
            results.append(await aborted_frame(
                ctx, backmap, rng, moment, .8,
                lambda words=words: write_word(ctx, backmap.writes, words)))
            await write_bank(ctx, backmap.writes, words)    # what a short frame leaves

    run_bench(dut, bench)
    cuts = 0
    for number, (frame, cut) in enumerate(results):
        whole = expected((d, other)[number % 2], strip, lanes)
        if not cut:
            np.testing.assert_array_equal(frame, whole)
            continue
        cuts += 1
        np.testing.assert_array_equal(frame[:-lanes], whole[:len(frame) - lanes])
        assert (frame[-lanes:, 2:] == [1, len(frame) == lanes, 1]).all()
    assert cuts >= 4 and not results[-1][1]


def test_a_picture_without_a_pixel_ends_and_the_next_is_whole():
    d = at_nodes(16)
    dut, results = FrontEnd(d, share=4), []

    async def bench(ctx):
        for height in (0, d.geometry.corrected_height):
            await prepare(ctx, dut.backmap, d)
            load(ctx, dut.backmap, d)
            ctx.set(dut.backmap.scan.height, height)
            ctx.set(dut.backmap.start, 1)
            await ctx.tick()
            ctx.set(dut.backmap.start, 0)
            results.append(fields(await get(ctx, dut.backmap.o, height * 72 or 1, lambda: False)))

    run_bench(dut, bench)
    assert results[0][0, 2:].tolist() == [1, 1, 1]
    np.testing.assert_array_equal(results[1], expected(d))


@pytest.mark.longer
@pytest.mark.parametrize("nodes,lanes,share", [
    pytest.param(8, 1, 2, marks=pytest.mark.regress), (16, 4, 2),
    pytest.param(32, 1, 4, marks=pytest.mark.regress)])
def test_weights_at_the_limits_and_changed_between_frames(nodes, lanes, share):
    """Also nodes at the limits of their format, between which coordinates saturate."""
    d = at_nodes(nodes, (132, 9), neurons=5)
    cases = [extreme(d, 1), d, extreme(d, 2), extreme(d, 3)]
    for frame, case in zip(frames(FrontEnd(d, lanes, share=share), cases, 0), cases):
        np.testing.assert_array_equal(frame, expected(case, lanes=lanes))
    q = d.formats.coordinate
    assert {q.lo, q.hi} <= set(np.ravel([expected(case)[:, :2] for case in cases]).tolist())


@pytest.mark.longer
@pytest.mark.parametrize("nodes,width,strip,lanes,share", [
    (8, 96, 0, 2, 3), (8, 128, 64, 1, 5),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        (16, 96, 0, 1, 8),
        (8, 96, 0, 1, 6), (32, 160, 0, 1, 20), (16, 128, 0, 4, 2), (8, 72, 0, 1, 6)))])
def test_a_group_per_clock_if_the_nodes_keep_up(nodes, width, strip, lanes, share):
    d = at_nodes(nodes, (width, 12), neurons=max(share, 4))
    dut, valid = FrontEnd(d, lanes, share=share), []
    groups = width * 12 // lanes

    async def bench(ctx):
        await prepare(ctx, dut.backmap, d)
        load(ctx, dut.backmap, d, strip)
        ctx.set(dut.backmap.o.ready, 1)
        ctx.set(dut.backmap.start, 1)
        await ctx.tick()
        ctx.set(dut.backmap.start, 0)
        for _ in range(groups + 400):
            valid.append((await ctx.tick().sample(dut.backmap.o.valid))[2])

    run_bench(dut, bench)
    arrived = np.flatnonzero(valid)
    assert len(arrived) == groups
    assert arrived[0] + 1 == dut.backmap.start_latency
    # Nodes of later rows come while earlier pixels go out; only at the start there are too few.
    assert arrived[-1] - arrived[0] < 1.02 * groups + share * nodes
