"""Levels of a sensor's samples: every sample, by several curves."""

import numpy as np
import pytest

from ncdc_hdl.camera.level import Level
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.level import LINEAR, check_curve, levelled
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
