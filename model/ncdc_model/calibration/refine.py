"""The minimum of a robust least-squares fit, in digits that are the same on every machine."""

import numpy as np

from ncdc_model.calibration.descent import Slope, robust_cost
from ncdc_model.exact import solve

__all__ = ["refine"]

_STEPS = 200
_GRAIN = 2.0**-14      # of what moves the residuals by 1 px: the result is a multiple of it
_DONE = 2.0**-12 * _GRAIN   # a step below it is the last: starts differ from machine to machine
_DAMPED = 1e-6, 1e3    # smallest damping of a step that has to be repeated, and when to give up
_EASED = 0.1           # of the damping, after a step that lowered the cost


def refine(residuals, derivatives, start, robust):
    """Parameters near ``start`` of least Huber cost of ``residuals``, rounded to a coarse grain.

    A search ends as soon as the cost hardly falls; where exactly depends on the last bits of its
    linear algebra. Damped Gauss-Newton steps go on from there until a step
    is far below the grain. They reach the same minimum from any start. Rounding to the grain
    removes what the order of summation leaves.

    Parameters
    ----------
    residuals : callable
        Array of residuals of a vector of parameters, in pixels.
    derivatives : callable
        Derivatives of the residuals by the parameters of a vector, one row per parameter.
    start : ndarray
        Close to the minimum. If no step lowers the cost, it is returned rounded.
    robust : float
        Residuals beyond it count linearly.
    """
    here, value, damping = start, residuals(start), 0.0
    scale = _scales(derivatives, here)
    slope = None
    for _ in range(_STEPS):
        if slope is None:       # its last bits only change how fast a step leads
            slope = Slope(value, derivatives(here) * scale[:, None], robust)
        damped = slope.normal + damping * np.diag(np.diag(slope.normal))
        step = solve(damped[None], -slope.gradient[None, :, None])[0, :, 0]
        trial = here + scale * step
        found = residuals(trial)
        if not robust_cost(found, robust) < robust_cost(value, robust) * (1 + 1e-9):
            damping = max(damping / _EASED, _DAMPED[0])
            if damping > _DAMPED[1]:
                break
            continue
        here, value, slope = trial, found, None
        damping = damping * _EASED if damping > _DAMPED[0] else 0.0
        if np.abs(step).max() < _DONE and not damping:
            break
    grain = _GRAIN * scale
    return np.rint(here / grain) * grain


def _scales(derivatives, here):
    """Powers of two: changes of each parameter that move the residuals by about 1 px."""
    moved = np.sqrt((derivatives(here)**2).sum(axis=1))
    return 2.0**-np.rint(np.log2(np.maximum(moved, 1e-12)))

