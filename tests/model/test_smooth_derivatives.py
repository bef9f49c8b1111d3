"""Derivatives of the smooth lens, compared with differences."""

import numpy as np
import pytest

from ncdc_model.calibration.smooth_problem import Problem
from ncdc_model.calibration.smooth_vector import FLAWS, fixed

_LENS = [600, 640, 480, -.05, .01, .002, -.001, .002, -.001, .3, .1, .001, -.002, .02, -.03, .05,
         .02]
_POSES = [.1, -.2, .3, -4, -3, 9], [-.2, .4, -.1, -3, -2, 2.5], [0, 0, 0, -4, -2, 1]


@pytest.mark.parametrize("flaws", [(), ("tilt",), tuple(FLAWS)])
def test_each_parameter(flaws):
    # The last photo sees more than 90 degrees from the axis, its target is not turned.
    index = np.stack(np.meshgrid(np.arange(9.), np.arange(6.)), -1).reshape(-1, 2)
    problem = Problem((1280, 960), [(index, np.full((54, 2), 500.))] * len(_POSES))
    vector = np.concatenate([_LENS, *_POSES]).astype(np.float64)
    found = problem.derivatives(vector, .7, flaws)
    for k, row in enumerate(found):
        step = np.zeros(len(vector))
        step[k] = 1e-6 * max(abs(vector[k]), .01)
        change = (problem.residuals(vector + step, .7) - problem.residuals(vector - step, .7))
        expected = change / (2 * step[k])
        if k in fixed(flaws):
            assert not row.any() and expected.any()
        else:
            np.testing.assert_allclose(row, expected, atol=2e-6 * np.abs(expected).max())
