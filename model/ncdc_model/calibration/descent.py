"""Levenberg-Marquardt on residuals of which large ones count linearly."""

import numpy as np

__all__ = ["Slope", "descend", "robust_cost"]

_STEPS = 100
_FALL = 1e-6           # of the cost: a step that lowers it by less is the last
_FIRST = 1e-3          # damping of the first step, in parts of the normal matrix's diagonal
_DAMPED = 1e-9, 1e8    # smallest damping, and when to give up


class Slope:
    """Jacobian, weighted normal matrix and gradient of the Huber cost at one vector.

    Parameters
    ----------
    value : ndarray, shape (n,)
        Residuals.
    jacobian : ndarray, shape (m, n)
        Their derivatives, a row for each parameter.
    robust : float
        Residuals beyond it count linearly.
    """

    def __init__(self, value, jacobian, robust):
        weighted = jacobian * np.minimum(1.0, robust / np.maximum(np.abs(value), 1e-300))
        self.normal, self.gradient = weighted @ jacobian.T, (weighted * value).sum(axis=1)


def robust_cost(value, robust):
    """Huber cost of residuals: half the square of each, linear beyond ``robust``."""
    far = np.abs(value)
    return np.where(far <= robust, .5 * far**2, robust * (far - .5 * robust)).sum()


def descend(residuals, derivatives, start, robust, fall=_FALL):
    """Parameters of a local minimum of the Huber cost, and that cost.

    Parameters
    ----------
    residuals, derivatives : callable
        Arrays (n,) and (m, n) of a vector (m,). A parameter without influence stays.
    start : ndarray, shape (m,)
    robust : float
        Residuals beyond it count linearly.
    fall : float
        Part of the cost: a step that lowers it by less is the last.
    """
    here, value, slope = start, residuals(start), None
    cost, damping, growth = robust_cost(value, robust), _FIRST, 2.0
    for _ in range(_STEPS):
        if slope is None:
            slope = Slope(value, derivatives(here), robust)
            diagonal = np.diag(slope.normal)
        damped = slope.normal + np.diag(np.where(diagonal > 0, damping * diagonal, 1.0))
        move = np.linalg.solve(damped, -slope.gradient)
        expected = -move @ (slope.gradient + slope.normal @ move / 2)
        found = residuals(here + move)
        lower = robust_cost(found, robust)
        if lower < cost:
            # Nielsen's rule: shrink by the quality of the quadratic model, grow progressively.
            off = 2 * (cost - lower) / max(expected, 1e-300) - 1
            damping, growth = max(damping * max(1 / 5, 1 - off**3), _DAMPED[0]), 2.0
            here, value, slope, gain, cost = here + move, found, None, cost - lower, lower
            if gain < fall * cost:
                break
        else:
            damping, growth = damping * growth, 2 * growth
            if damping > _DAMPED[1]:
                break
    return here, cost
