"""Medians of the finite numbers along an axis."""

import warnings

import numpy as np
import pytest

from ncdc_model.calibration.median import known_median


@pytest.mark.parametrize("shape", [(1, 1), (7, 4), (5, 9), (6, 24, 2), (3, 5, 2, 4)])
def test_they_are_numpy_s(shape):
    rng = np.random.default_rng(len(shape))
    values = rng.normal(size=shape)
    values[rng.random(shape) < .4] = np.nan
    values[0] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        expected = np.nanmedian(values, axis=1)
    np.testing.assert_array_equal(known_median(values), expected)
