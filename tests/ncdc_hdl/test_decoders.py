"""The decoders of 6x6 windows and their bilinear interpolator, compared with the golden model."""

import numpy as np
import pytest

from fetchers import flipped, turned
from ncdc_hdl.backend.bilinear import Bilinear
from ncdc_hdl.backend.directional import Crest, Direction, DirectionalPoints
from ncdc_hdl.backend.gradient import GradientPoints
from ncdc_hdl.backend.interpolator import Interpolator
from ncdc_model.golden.directional import crest_of, directional_colours, twice_direction
from ncdc_model.golden.picture import bilinear, gradient_colours, grey_corners
from ncdc_spec.interpolation import DIRECTIONAL, GRADIENT
from pipelines import get, run_bench, run_pipeline, send

F = 10
GATEWARE = {GRADIENT: GradientPoints, DIRECTIONAL: DirectionalPoints}
MODEL = {GRADIENT: gradient_colours, DIRECTIONAL: directional_colours}
# Largest sums of the weights of one sign, and of the other: what a colour can reach.
LARGEST = {GRADIENT: (28, 12), DIRECTIONAL: (36, 20)}
both = pytest.mark.parametrize("needs", GATEWARE, ids=lambda each: each.name)


def used(needs, window):
    """The samples of a window that the interpolation takes."""
    rows, columns = zip(*needs.samples)
    return window[rows, columns].tolist()


def extremes(column, row):
    """Windows that drive a kernel of the first corner in this phase to both of its ends."""
    rng = np.random.default_rng(2)
    windows = rng.integers(0, 256, (150, 6, 6))
    windows[0], windows[1] = 0, 255
    for k in range(2, 80):
        # All samples at either end: what makes a corner of some colour largest is among them.
        windows[k] = 255 * rng.integers(0, 2, (6, 6))
    basis = np.eye(36, dtype=int).reshape(36, 6, 6)
    weights = gradient_colours(basis, 0, 0, (column, row)).reshape(12, 6, 6)
    return np.concatenate([windows, 255 * (weights > 0), 255 * (weights < 0)])


def test_the_direction_equals_model():
    rng = np.random.default_rng(8)
    windows = rng.integers(0, 256, (400, 6, 6))
    windows[:100] = 255 * rng.integers(0, 2, (100, 6, 6))
    windows[100:250] = windows[100:250, :1] + rng.integers(-8, 9, (150, 6, 6))     # along columns
    windows[250:] = windows[250:].swapaxes(1, 2)
    windows = windows.clip(0, 255)
    dut = Direction()
    got = run_pipeline(dut, list(windows), lambda ctx, window: ctx.set(
        dut.samples, used(DIRECTIONAL, window)), lambda: [dut.o.whole, dut.o.half, dut.o.minus])
    twice = [(2 if whole else half) * (-1 if minus else 1) for whole, half, minus in got]
    np.testing.assert_array_equal(twice, twice_direction(windows))
    assert set(twice) == {-2, -1, 0, 1, 2}


@both
@pytest.mark.parametrize("column", range(2))
@pytest.mark.parametrize("row", range(2))
def test_corners_equal_model_in_every_phase(needs, column, row):
    windows = extremes(column, row)
    dut = GATEWARE[needs]()

    flip = flipped(0, 0, (column, row))
    got = run_pipeline(dut, list(windows), lambda ctx, window: ctx.set(
        dut.samples, used(needs, turned(window, flip))), lambda: list(dut.o))
    corners = np.array(got).reshape(-1, 2, 2, 3)
    for window, corner in zip(windows, corners):
        corner = turned(corner.transpose(2, 0, 1), flip).transpose(1, 2, 0)
        np.testing.assert_array_equal(corner if column else corner[..., ::-1],
                                      MODEL[needs](window, 0, 0, (column, row)))
    high, low = LARGEST[needs]
    assert corners.max() <= high * 255 and corners.min() >= -low * 255
    # The direction follows the samples: not all weights of a sign meet the extremes at once.
    assert needs == DIRECTIONAL or (corners.max(), corners.min()) == (high * 255, -low * 255)


@both
def test_green_of_a_grey_sensor_is_each_sample(needs):
    windows = extremes(0, 0)
    dut = GATEWARE[needs]()

    def drive(ctx, window):
        ctx.set(dut.samples, used(needs, window))
        ctx.set(dut.mono, 1)

    for window, corners in zip(windows, run_pipeline(dut, list(windows), drive,
                                                     lambda: list(dut.o))):
        np.testing.assert_array_equal(np.array(corners).reshape(2, 2, 3)[..., 1],
                                      grey_corners(window)[:, :, 1])


@pytest.mark.parametrize("f_bits", [4, 8, 10, 12])
@both
def test_bilinear_equals_model_and_clamps(needs, f_bits):
    rng = np.random.default_rng(3)
    high, low = (255 * sign for sign in LARGEST[needs])
    corners = rng.integers(-low, high + 1, (2, 2, 3, 400))
    corners[..., 0], corners[..., 1] = high, -low
    corners[:, 0, :, 2], corners[:, 1, :, 2] = -low, high
    corners[0, :, :, 3], corners[1, :, :, 3] = -low, high
    last = (1 << f_bits) - 1
    fractions = rng.integers(0, last + 1, (400, 2))
    fractions[:5] = [[0, 0], [0, 0], [last, last], [last, 0], [0, last]]
    flips = [{"x": int(x), "y": int(y)} for x, y in rng.integers(0, 2, (400, 2))]
    dut = Bilinear(f_bits, needs, GATEWARE[needs]().signature.members["o"].shape)

    def drive(ctx, k):
        points = turned(corners[..., k].transpose(2, 0, 1), flips[k]).transpose(1, 2, 0)
        ctx.set(dut.i, points.ravel().tolist())
        for axis, f in zip("xy", fractions[k].tolist()):
            ctx.set(getattr(dut, f"f{axis}"), (1 << f_bits) - f if flips[k][axis] else f)
        if needs == DIRECTIONAL:
            ctx.set(dut.crest, 32)      # no crest: the half of the rounding alone

    got = np.array(run_pipeline(dut, list(range(400)), drive, lambda: list(dut.o)))
    np.testing.assert_array_equal(got, bilinear(corners, *fractions.T, f_bits, needs))
    assert {0, 255} <= set(got.ravel().tolist())


@pytest.mark.parametrize("strength", range(3))
def test_the_crest_equals_model(strength):
    rng = np.random.default_rng(4)
    windows, fractions = rng.integers(0, 256, (300, 6, 6)), rng.integers(0, 1 << F, (300, 2))
    windows[:100] = 255 * rng.integers(0, 2, (100, 6, 6))
    fractions[:4] = [[0, 1023], [511, 512], [512, 511], [1023, 0]]
    dut = Crest(F)
    coarse = windows >> 2
    bends = [(w[2:4, 1] - w[2:4, 2] - w[2:4, 3] + w[2:4, 4]).sum() for w in coarse]
    turned = [(w[1, 2:4] - w[2, 2:4] - w[3, 2:4] + w[4, 2:4]).sum() for w in coarse]

    def drive(ctx, k):
        ctx.set(dut.bend, {"x": int(bends[k]), "y": int(turned[k])})
        ctx.set(dut.fx, int(fractions[k, 0]))
        ctx.set(dut.fy, int(fractions[k, 1]))
        ctx.set(dut.strength, strength)

    got = np.array(run_pipeline(dut, list(range(300)), drive, lambda: [dut.o])).ravel()
    np.testing.assert_array_equal(got - 32, crest_of(windows, *fractions.T, F, strength))
    assert bool(strength) == bool((got != 32).any())


@pytest.mark.parametrize("needs,gap,stall,mono,crest", [
    *((needs, gap, stall, mono, 0) for needs in GATEWARE for gap, stall, mono in
      ((0, 0, False), (.3, .7, False), (.3, .7, True))),
    (DIRECTIONAL, 0, 0, False, 1), (DIRECTIONAL, .3, .7, False, 2), (DIRECTIONAL, .3, .3, True, 1)])
def test_stream_equals_model(needs, gap, stall, mono, crest):
    rng = np.random.default_rng(6)
    count = 200
    windows, fractions = rng.integers(0, 256, (count, 6, 6)), rng.integers(0, 1024, (count, 2))
    origins, blank = rng.integers(0, 2, (count, 2)), rng.random(count) < .2
    fill, phase = 0x123456, (1, 0)
    flips = [flipped(x, y, phase) for x, y in origins.tolist()]
    items = [{"samples": used(needs, turned(windows[k], flips[k])), "flipped": flips[k],
              "fx": int(fractions[k, 0]), "fy": int(fractions[k, 1]), "blank": int(blank[k]),
              "first": k == 0, "last": k == count - 1} for k in range(count)]
    dut, got = Interpolator(F, interpolation=needs, window_latency=int(30 * gap)), []

    async def source(ctx):
        ctx.set(dut.phase, phase[0] | phase[1] << 1)
        ctx.set(dut.fill, fill)
        ctx.set(dut.mono, mono)
        if needs == DIRECTIONAL:
            ctx.set(dut.crest, crest)
        await send(ctx, dut.i, items, lambda: rng.random() < gap, dut.window_latency)

    async def sink(ctx):
        got.extend(await get(ctx, dut.o, count, lambda: rng.random() < stall))

    run_bench(dut, source, sink)
    corners = grey_corners(windows) if mono else MODEL[needs](windows, *origins.T, phase)
    expected = bilinear(corners, *fractions.T, F, needs,
                        crest_of(windows, *fractions.T, F, crest))
    expected[blank] = [0x12, 0x34, 0x56]
    np.testing.assert_array_equal([[p.r, p.g, p.b] for p in got], expected)
    assert [k for k, p in enumerate(got) if p.first] == [0]
    assert [k for k, p in enumerate(got) if p.last] == [count - 1]
