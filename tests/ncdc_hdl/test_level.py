"""Levels of a sensor's samples: every sample, by several curves."""

import numpy as np
import pytest

from ncdc_hdl.camera.level import Level
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.level import LINEAR, check_curve, levelled
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY
from pipelines import run_pipeline

CURVES = [(0, LINEAR), (168, (0, 40, *range(56, 257, 16), 254, 250)), (4095, LINEAR),
          (1, tuple(256 - 16 * k for k in range(17))), (42, (256, 0) * 8 + (256,))]


@pytest.mark.parametrize("black,curve", CURVES)
def test_equals_model(black, curve):
    dut, samples = Level(), range(4096)

    def drive(ctx, sample):
        ctx.set(dut.level, {"black": black, "curve": curve})
        ctx.set(dut.i, sample)

    found = run_pipeline(dut, samples, drive, lambda: [dut.o])
    assert np.array_equal(np.ravel(found), levelled(samples, black, curve))


@pytest.mark.parametrize("black,curve", CURVES[1:3])
def test_gain_of_each_sample(black, curve):
    rng = np.random.default_rng(3)
    gains = np.array([0, 1, 128, UNITY - 1, UNITY, UNITY + 1, 2 * UNITY, LARGEST_GAIN])
    samples = np.concatenate([np.tile(np.arange(4096), 2), np.full(len(gains), 4095)])
    each = np.concatenate([rng.choice(gains, 4096), rng.integers(0, 1024, 4096), gains])
    dut = Level()

    def drive(ctx, item):
        ctx.set(dut.level, {"black": black, "curve": curve})
        ctx.set(dut.i, int(item[0]))
        ctx.set(dut.gain, int(item[1]))

    found = run_pipeline(dut, list(zip(samples, each)), drive, lambda: [dut.o])
    assert np.array_equal(np.ravel(found), levelled(samples, black, curve, each))


def test_gains_round_to_nearest_and_leave_full_samples_white():
    # 3 * 128 / 256 = 1.5 becomes 2: with a curve of slope 16 / 256 a byte tells samples apart.
    steep = (0, *[256] * 16)
    assert levelled([3, 5], gains=UNITY // 2, curve=steep).tolist() == [2, 3]
    assert levelled(4095, 168, gains=np.array([UNITY, 2 * UNITY, LARGEST_GAIN])).tolist() == [
        levelled(4095, 168)] * 3


def test_a_sensor_of_eight_bits_is_left_as_it_is():
    assert np.array_equal(levelled(np.arange(256) << 4), np.arange(256))


def test_rounds_to_nearest():
    assert levelled([7, 8, 23, 24, 4087, 4088, 4095]).tolist() == [0, 1, 1, 2, 255, 255, 255]


@pytest.mark.parametrize("curve,sentence", [
    ((0,) * 16, "the curve has 16 nodes, it must have 17"),
    ((0,) * 16 + (257,), "a node of the curve is 257, it must be an integer of 0 to 256"),
    ((0,) * 16 + (0.5,), "a node of the curve is 0.5, it must be an integer of 0 to 256")])
def test_a_curve_that_is_none(curve, sentence):
    with pytest.raises(InputError, match=sentence):
        check_curve(curve)
