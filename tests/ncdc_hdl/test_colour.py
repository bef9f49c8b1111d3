"""White balance and tone: every value by many gains and curves, sums of groups of pixels."""

import numpy as np
import pytest

from ncdc_hdl.backend.colour import Colour, ColourSums
from ncdc_model.golden.colour import coloured
from ncdc_model.golden.corrector import Corrected
from ncdc_model.golden.tone import tone_named
from ncdc_spec.colour import Colour as Settings
from ncdc_spec.tone import LINEAR, NODE_POSITIONS
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY
from pipelines import run_bench, run_pipeline

NODES = len(NODE_POSITIONS)
INVERTED = tuple(256 - position for position in NODE_POSITIONS)
ZIGZAG = (0, 256) * (NODES // 2) + (0,)


def model(pixels, settings):
    """Pixels, of the shape (count, 3), by the golden model."""
    picture = np.asarray(pixels, np.uint8)[None]
    return coloured(Corrected(picture, np.zeros(picture.shape[:2], bool), 0), settings)[0]


def gateware(pixels, settings=None):
    """The same by the gateware; at reset values without ``settings``."""
    dut = Colour()

    def drive(ctx, pixel):
        if settings:
            ctx.set(dut.colour, {"gains": settings.gains, "tone": settings.tone})
        ctx.set(dut.i, pixel)

    return run_pipeline(dut, np.asarray(pixels).tolist(), drive, lambda: list(dut.o))


def every_value(seed=0):
    """All 256 values of each colour, in three orders, and as many random pixels."""
    rng = np.random.default_rng(seed)
    values = np.arange(256)
    return np.concatenate([np.stack([values, values[::-1], rng.permutation(256)], axis=1),
                           rng.integers(0, 256, (256, 3))])


@pytest.mark.parametrize("gains,tone", [
    ((0, 1, LARGEST_GAIN), LINEAR), ((UNITY - 1, UNITY, UNITY + 1), LINEAR),
    ((461, 256, 358), tone_named("sRGB")), ((128, 512, 300), tone_named("gamma:2.2")),
    ((256, 256, 256), INVERTED), ((256, 700, 90), ZIGZAG), ((256, 256, 256), (256,) * NODES),
    ((LARGEST_GAIN,) * 3, (0,) * NODES)])
def test_equals_model(gains, tone):
    settings = Settings(gains, tone)
    np.testing.assert_array_equal(gateware(every_value(), settings), model(every_value(), settings))


@pytest.mark.parametrize("seed", range(3))
def test_equals_model_with_random_settings(seed):
    rng = np.random.default_rng(seed)
    settings = Settings(tuple(rng.integers(0, LARGEST_GAIN + 1, 3).tolist()),
                        tuple(rng.integers(0, 257, NODES).tolist()))
    np.testing.assert_array_equal(gateware(every_value(seed), settings),
                                  model(every_value(seed), settings))


def test_nothing_changes_at_reset():
    np.testing.assert_array_equal(gateware(every_value()), every_value())


@pytest.mark.parametrize("lanes", [1, 4])
def test_sums_are_those_of_each_frame(lanes):
    """Two frames of random and of full pixels, of which some do not count."""
    rng = np.random.default_rng(lanes)
    frames = [rng.integers(0, 256, (50, lanes, 3)), np.full((70, lanes, 3), 255)]
    counts = [rng.random((50, lanes)) < .7, np.ones((70, lanes), bool)]
    dut, found = ColourSums(lanes), []

    async def bench(ctx):
        for groups, counted in zip(frames, counts):
            ctx.set(dut.begin, 1)
            await ctx.tick()
            ctx.set(dut.begin, 0)
            for group, some in zip(groups, counted):
                ctx.set(dut.i, group.tolist())
                ctx.set(dut.counts, sum(int(bit) << k for k, bit in enumerate(some)))
                await ctx.tick()
            ctx.set(dut.counts, 0)
            await ctx.tick().repeat(dut.latency - 1)
            sums = ctx.get(dut.sums)
            found.append([sums.red, sums.green, sums.blue, sums.pixels])

    run_bench(dut, bench)
    assert found == [[*groups[some].sum(axis=0).tolist(), int(some.sum())]
                     for groups, some in zip(frames, counts)]
