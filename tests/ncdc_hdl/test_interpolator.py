"""Bayer decoder and bilinear interpolator compared with the golden model."""

import numpy as np
import pytest

from ncdc_hdl.backend.bayer import BayerQuads
from ncdc_hdl.backend.bilinear import Bilinear
from ncdc_hdl.backend.interpolator import Interpolator
from ncdc_hdl.lib.credits import CreditQueue
from ncdc_model.golden.picture import bayer_quads, bilinear
from ncdc_spec.geometry import BAYER_PHASE
from pipelines import get, run_bench, run_pipeline, send

F = 10


def test_bayer_quads_equal_model_in_every_phase():
    rng = np.random.default_rng(2)
    windows = rng.integers(0, 256, (64, 3, 3))
    windows[0], windows[1] = 0, 255
    dut = BayerQuads()
    for column in range(2):
        for row in range(2):
            def drive(ctx, window):
                ctx.set(dut.samples, window.ravel().tolist())
                ctx.set(dut.red_column, column == 0)
                ctx.set(dut.red_row, row == 0)

            got = run_pipeline(dut, list(windows), drive, lambda: list(dut.o))
            expected = bayer_quads(windows, 0, 0, (column, row))
            np.testing.assert_array_equal(np.array(got).T.reshape(2, 2, 3, -1), expected)


def test_bayer_quads_of_a_flat_colour_are_that_colour():
    """Red, green and blue must not be swapped, whatever the phase and the position."""
    for bayer, (column, row) in BAYER_PHASE.items():
        raw = np.full((6, 6), 50)
        raw[row::2, column::2], raw[1 - row::2, 1 - column::2] = 200, 10
        for y0 in range(2):
            for x0 in range(2):
                quads = bayer_quads(raw[y0:y0 + 3, x0:x0 + 3], x0, y0, (column, row))
                assert (quads.reshape(4, 3) == [400, 100, 20]).all(), (bayer, x0, y0)


@pytest.mark.parametrize("f_bits", [6, 8, 9, 10, 12])
def test_bilinear_equals_model(f_bits):
    rng = np.random.default_rng(3)
    quads = rng.integers(0, 511, (2, 2, 3, 400))
    quads[..., 0], quads[..., 1] = 510, 0
    quads[:, 0, :, 2], quads[:, 1, :, 2] = 0, 510
    last = (1 << f_bits) - 1
    fractions = rng.integers(0, last + 1, (400, 2))
    fractions[:4] = [[0, 0], [0, 0], [last, last], [last, 0]]
    dut = Bilinear(f_bits)

    def drive(ctx, k):
        ctx.set(dut.i, quads[..., k].ravel().tolist())
        ctx.set(dut.fx, int(fractions[k, 0]))
        ctx.set(dut.fy, int(fractions[k, 1]))

    got = run_pipeline(dut, list(range(400)), drive, lambda: list(dut.o))
    np.testing.assert_array_equal(got, bilinear(quads, *fractions.T, f_bits))


def test_bilinear_rounds_to_nearest():
    rng = np.random.default_rng(4)
    quads, fx, fy = rng.integers(0, 511, (2, 2, 3, 5000)), *rng.integers(0, 1024, (2, 5000))
    exact = ((1 - fy / 1024) * ((1 - fx / 1024) * quads[0, 0] + fx / 1024 * quads[0, 1])
             + fy / 1024 * ((1 - fx / 1024) * quads[1, 0] + fx / 1024 * quads[1, 1])) / 2
    assert np.abs(bilinear(quads, fx, fy, F).T - exact).max() <= 0.5


@pytest.mark.parametrize("gap,stall", [(0, 0), (.5, 0), (0, .6), (.3, .7)])
def test_stream_equals_model(gap, stall):
    rng = np.random.default_rng(6)
    count = 200
    windows, fractions = rng.integers(0, 256, (count, 3, 3)), rng.integers(0, 1024, (count, 2))
    origins, blank = rng.integers(0, 2, (count, 2)), rng.random(count) < .2
    fill, phase = 0x123456, (1, 0)
    items = [{"samples": windows[k].ravel().tolist(), "odd_column": int(origins[k, 0]),
              "odd_row": int(origins[k, 1]), "fx": int(fractions[k, 0]), "fy": int(fractions[k, 1]),
              "blank": int(blank[k]), "first": k == 0, "last": k == count - 1}
             for k in range(count)]
    dut, got = Interpolator(F, window_latency=int(9 * gap)), []

    async def source(ctx):
        ctx.set(dut.phase, phase[0] | phase[1] << 1)
        ctx.set(dut.fill, fill)
        await send(ctx, dut.i, items, lambda: rng.random() < gap, dut.window_latency)

    async def sink(ctx):
        got.extend(await get(ctx, dut.o, count, lambda: rng.random() < stall))

    run_bench(dut, source, sink)
    expected = bilinear(bayer_quads(windows, *origins.T, phase), *fractions.T, F)
    expected[blank] = [0x12, 0x34, 0x56]
    np.testing.assert_array_equal([[p.r, p.g, p.b] for p in got], expected)
    assert [k for k, p in enumerate(got) if p.first] == [0]
    assert [k for k, p in enumerate(got) if p.last] == [count - 1]


def test_no_clock_is_lost_to_credits():
    """The queue has space for all windows under way, however early they are announced."""
    dut, count, clocks = Interpolator(F, window_latency=30), 200, []

    async def source(ctx):
        await send(ctx, dut.i, [{"blank": 1}] * count, lambda: False, dut.window_latency)

    async def sink(ctx):
        ctx.set(dut.o.ready, 1)
        while sum(clocks) < count:
            clocks.append((await ctx.tick().sample(dut.o.valid))[2])

    run_bench(dut, source, sink)
    first = dut.window_latency + dut.latency + CreditQueue.latency
    assert clocks == [0] * first + [1] * count
