"""Values of a picture at lists of positions."""

import cv2
import numpy as np
import pytest
from scipy.ndimage import map_coordinates

from ncdc_model.calibration.sampling import bilinear, sample


def ramp(dtype):
    y, x = np.mgrid[:40, :60]
    return (3 * x + 2 * y).astype(dtype)


@pytest.mark.parametrize("shape", [(), (0,), (5,), (40_000,), (9_000, 4), (12_000, 3, 2)])
def test_any_number_of_positions_in_any_shape(shape):
    positions = np.random.default_rng(1).uniform((0, 0), (58, 38), (*shape, 2))
    values = sample(ramp(np.float32), positions)
    assert values.shape == shape and values.dtype == np.float32
    # OpenCV may count positions in 32nds of a pixel.
    np.testing.assert_allclose(values, 3 * positions[..., 0] + 2 * positions[..., 1], atol=0.1)


@pytest.mark.parametrize("kernel", [cv2.INTER_LINEAR, cv2.INTER_CUBIC])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_blocks_change_nothing(kernel, dtype):
    picture = np.random.default_rng(2).uniform(0, 255, (50, 70)).astype(dtype)
    positions = np.random.default_rng(3).uniform(-3, 75, (100, 500, 2)).astype(np.float32)
    at_once = cv2.remap(picture, positions, None, kernel, borderMode=cv2.BORDER_REPLICATE)
    np.testing.assert_array_equal(sample(picture, positions, kernel), at_once)


def test_beyond_the_border_are_the_border_s_values():
    assert sample(ramp(np.uint8), [(-9, -9), (99, 99)]).tolist() == [0, 3 * 59 + 2 * 39]


@pytest.mark.parametrize("shape", [(50, 70), (1, 9), (9, 1)])
@pytest.mark.parametrize("dtype", [np.uint8, np.float32])
def test_bilinear_samples_are_exact(shape, dtype):
    picture = np.random.default_rng(4).uniform(0, 255, shape).astype(dtype)
    positions = np.random.default_rng(5).uniform(-4, 74, (300, 3, 2))
    expected = map_coordinates(picture, [positions[..., 1], positions[..., 0]], np.float32, order=1,
                               mode="nearest")
    np.testing.assert_array_equal(bilinear(picture, positions), expected)
