"""The minimum of a robust least-squares fit, to digits that do not depend on who adds."""

import numpy as np

from ncdc_model.exact import solve

__all__ = ["settle"]

_STEPS = 200
_PROBE = 4.0           # px: root of the sum of squares by which a probe moves the residuals
_GRAIN = 2.0**-14      # of what moves the residuals by 1 px: the result is a multiple of it
_DONE = 2.0**-12 * _GRAIN   # a step below it is the last: starts differ from machine to machine


def settle(residuals, start, robust):
    """Parameters near ``start`` of least Huber cost of ``residuals``, rounded to a coarse grain.

    ``scipy.optimize.least_squares`` ends as soon as the cost hardly falls; where exactly depends
    on the last bits of its linear algebra. From there Gauss-Newton steps go on to the minimum
    itself, whatever the start, until a step is far below the grain.
    What is left of the order of summation is rounded away.

    Parameters
    ----------
    residuals : callable
        Array of residuals of a vector of parameters, in pixels.
    start : ndarray
        Close to the minimum. If no step leads on from there, it is returned rounded.
    robust : float
        Residuals beyond it count linearly.
    """
    here, step, scale = start, None, None
    value = residuals(here)
    for _ in range(_STEPS):
        if scale is None:
            scale = _scales(residuals, here, value)
        jacobian = np.stack([(residuals(here + move) - residuals(here - move)) / (2 * _PROBE)
                             for move in np.diag(_PROBE * scale)])
        weight = np.minimum(1.0, robust / np.maximum(np.abs(value), 1e-300))
        weighted = jacobian * weight
        normal = np.array([(weighted * row).sum(1) for row in jacobian])
        step = solve(normal[None], -(weighted * value).sum(1)[None, :, None])[0, :, 0]
        trial = here + scale * step
        found = residuals(trial)
        if not _cost(found, robust) < _cost(value, robust) * (1 + 1e-9):
            break
        here, value = trial, found
        if np.abs(step).max() < _DONE:
            break
    grain = _GRAIN * scale
    return np.rint(here / grain) * grain


def _scales(residuals, here, value):
    """Powers of two: changes of each parameter that move the residuals by about 1 px."""
    small = 1e-6 * np.maximum(np.abs(here), 1e-3)
    moved = np.array([np.sqrt(((residuals(here + move) - value)**2).sum())
                      for move in np.diag(small)])
    return 2.0**np.rint(np.log2(small / np.maximum(moved, 1e-12)))


def _cost(value, robust):
    far = np.abs(value)
    return np.where(far <= robust, .5 * far**2, robust * (far - .5 * robust)).sum()
