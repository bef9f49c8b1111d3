"""The gradient-corrected decoder and its bilinear interpolator against the golden model."""

import numpy as np
import pytest

from ncdc_hdl.backend.bilinear import Bilinear
from ncdc_hdl.backend.gradient import GradientPoints
from ncdc_hdl.backend.interpolator import Interpolator
from ncdc_model.golden.picture import bilinear, gradient_colours, grey_corners
from ncdc_spec.interpolation import GRADIENT
from pipelines import get, put, run_bench, run_pipeline

F = 10
ROWS, COLUMNS = zip(*GRADIENT.samples)


def extremes(column, row):
    """Windows that drive a kernel of the first place in this phase to both of its ends."""
    rng = np.random.default_rng(2)
    windows = rng.integers(0, 256, (150, 6, 6))
    windows[0], windows[1] = 0, 255
    for k in range(2, 80):
        # All samples at either end: what makes a place of some colour largest is among them.
        windows[k] = 255 * rng.integers(0, 2, (6, 6))
    basis = np.eye(36, dtype=int).reshape(36, 6, 6)
    weights = gradient_colours(basis, 0, 0, (column, row)).reshape(12, 6, 6)
    return np.concatenate([windows, 255 * (weights > 0), 255 * (weights < 0)])


@pytest.mark.parametrize("column", range(2))
@pytest.mark.parametrize("row", range(2))
def test_places_equal_model_in_every_phase(column, row):
    windows = extremes(column, row)
    dut = GradientPoints()

    def drive(ctx, window):
        ctx.set(dut.samples, window[ROWS, COLUMNS].tolist())
        ctx.set(dut.red_column, column == 0)
        ctx.set(dut.red_row, row == 0)

    got = run_pipeline(dut, list(windows), drive,
                       lambda: [*dut.o, dut.reversed, dut.swapped])
    places = np.array([each[:12] for each in got]).reshape(-1, 2, 2, 3)
    for window, place, (*_, turned, swapped) in zip(windows, places, got):
        for j in range(2):
            if turned >> j & 1:
                place[j] = place[j, ::-1].copy()
        if swapped:
            place = place[..., ::-1]
        expected = gradient_colours(window, 0, 0, (column, row))
        np.testing.assert_array_equal(place, expected)
    assert places.max() == 28 * 255 and places.min() == -12 * 255


def test_green_of_a_grey_sensor_is_each_sample_wherever_it_lies():
    windows = extremes(0, 0)
    for parity in range(4):
        dut = GradientPoints()

        def drive(ctx, window):
            ctx.set(dut.samples, window[ROWS, COLUMNS].tolist())
            ctx.set(dut.red_column, parity & 1)
            ctx.set(dut.red_row, parity >> 1)
            ctx.set(dut.mono, 1)

        got = run_pipeline(dut, list(windows), drive, lambda: [*dut.o, dut.reversed])
        for window, (*places, turned) in zip(windows, got):
            green = np.array(places).reshape(2, 2, 3)[..., 1]
            for j in range(2):
                if turned >> j & 1:
                    green[j] = green[j, ::-1].copy()
            np.testing.assert_array_equal(green, grey_corners(window)[:, :, 1])


def test_bilinear_equals_model_and_clamps():
    rng = np.random.default_rng(3)
    places = rng.integers(-12 * 255, 28 * 255 + 1, (2, 2, 3, 400))
    places[..., 0], places[..., 1] = 28 * 255, -12 * 255
    places[:, 0, :, 2], places[:, 1, :, 2] = -12 * 255, 28 * 255
    places[0, :, :, 3], places[1, :, :, 3] = -12 * 255, 28 * 255
    fractions = rng.integers(0, 1 << F, (400, 2))
    fractions[:5] = [[0, 0], [0, 0], [1023, 1023], [1023, 0], [0, 1023]]
    turned = rng.integers(0, 4, 400)
    dut = Bilinear(F, GRADIENT, GradientPoints().signature.members["o"].shape)

    def drive(ctx, k):
        shown = places[..., k].copy()
        for j in range(2):
            if turned[k] >> j & 1:
                shown[j] = shown[j, ::-1].copy()
        ctx.set(dut.i, shown.ravel().tolist())
        ctx.set(dut.reversed, int(turned[k]))
        ctx.set(dut.fx, int(fractions[k, 0]))
        ctx.set(dut.fy, int(fractions[k, 1]))

    got = np.array(run_pipeline(dut, list(range(400)), drive, lambda: list(dut.o)))
    np.testing.assert_array_equal(got, bilinear(places, *fractions.T, F, GRADIENT.unit_bits))
    assert {0, 255} <= set(got.ravel().tolist())


@pytest.mark.parametrize("gap,stall,mono", [(0, 0, False), (.3, .7, False), (.3, .7, True)])
def test_stream_equals_model(gap, stall, mono):
    rng = np.random.default_rng(6)
    count = 200
    windows, fractions = rng.integers(0, 256, (count, 6, 6)), rng.integers(0, 1024, (count, 2))
    origins, blank = rng.integers(0, 2, (count, 2)), rng.random(count) < .2
    fill, phase = 0x123456, (1, 0)
    items = [{"samples": windows[k][ROWS, COLUMNS].tolist(), "odd_column": int(origins[k, 0]),
              "odd_row": int(origins[k, 1]), "fx": int(fractions[k, 0]),
              "fy": int(fractions[k, 1]), "blank": int(blank[k]), "first": k == 0,
              "last": k == count - 1} for k in range(count)]
    dut, got = Interpolator(F, interpolation=GRADIENT), []

    async def source(ctx):
        ctx.set(dut.phase, phase[0] | phase[1] << 1)
        ctx.set(dut.fill, fill)
        ctx.set(dut.mono, mono)
        await put(ctx, dut.i, items, lambda: rng.random() < gap)

    async def sink(ctx):
        got.extend(await get(ctx, dut.o, count, lambda: rng.random() < stall))

    run_bench(dut, source, sink)
    places = grey_corners(windows) if mono else gradient_colours(windows, *origins.T, phase)
    expected = bilinear(places, *fractions.T, F, GRADIENT.unit_bits)
    expected[blank] = [0x12, 0x34, 0x56]
    np.testing.assert_array_equal([[p.r, p.g, p.b] for p in got], expected)
    assert [k for k, p in enumerate(got) if p.first] == [0]
    assert [k for k, p in enumerate(got) if p.last] == [count - 1]
