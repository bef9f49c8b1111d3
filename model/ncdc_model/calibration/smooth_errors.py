"""Standard errors of a smooth lens, and which of its flaws the points show.

With the derivatives J of the points' pixels by all parameters and the variance s^2 of the
residuals, the covariance of the parameters is

    C = (J J^T / (k s^2) + P)^-1.

P is the prior of usual lenses. The factor k is 1 for residuals that are independent of each other.
Residuals of neighbours that are alike, as of an uneven lens or a bent page, tell less than their
number says: k is then the ratio of the mean square of sums over cells of the picture to what
independent residuals give.
"""

from dataclasses import dataclass

import numpy as np

from ncdc_model.calibration.smooth_problem import ROBUST, SPREAD, deviation
from ncdc_model.calibration.smooth_vector import FLAWS, LENS

__all__ = ["Estimate", "shown"]

_CELLS = (4, 8, 16)    # cells across the picture, over which residuals are summed
_LEAST = 1e-3          # pixels: standard deviation of exact points
_WORTH = 2.0           # per parameter: flaws that explain less chi-square are left out (Akaike)


@dataclass(frozen=True)
class Estimate:
    """What points say of the parameters of a smooth lens.

    Parameters
    ----------
    covariance : ndarray, shape (m, m)
        Of the parameters of the vector, and of further ones, see :meth:`of`.
    step : ndarray, shape (m,)
        From the vector to the estimate with all parameters free.
    alike : float
        The factor k of this module.
    """
    covariance: np.ndarray
    step: np.ndarray
    alike: float

    @classmethod
    def of(cls, problem, vector, more=None, spread=(), share=1.0):
        """Estimate of a ``problem`` at ``vector``, the parameters of a fit of it.

        ``more``: derivatives (b, 2 n) of the residuals by b further parameters, which are zero at
        ``vector``; ``spread`` (b,): their usual sizes. ``share``: of all points, those in
        ``problem``.
        """
        count = 2 * len(problem.owner)
        rows = problem.derivatives(vector)[:, :count]
        if more is not None:
            rows = np.concatenate([rows, more])
        rest = problem.errors(vector)
        near = np.clip(rest, -ROBUST, ROBUST)
        inner = max(float(np.mean(np.abs(rest) <= ROBUST)), 0.1)
        free = max(count - len(rows), count / 8)
        variance = max((near @ near) / free / inner**2, _LEAST**2)
        alike = _alike(problem, near.reshape(-1, 2), len(vector))
        variance *= share * alike
        prior = np.zeros(len(rows))
        usual = problem.units(vector) / SPREAD
        prior[:LENS], prior[len(vector):] = usual**2, np.asarray(spread, np.float64)**-2.0
        pull = np.zeros(len(rows))
        pull[:LENS] = usual / SPREAD * deviation(vector, problem.size)
        # Scaled: focal lengths and polynomials' terms differ by many powers of ten.
        matrix = rows @ rows.T / variance + np.diag(prior)
        scale = 1 / np.sqrt(np.maximum(np.diag(matrix), 1e-300))
        covariance = np.linalg.pinv(matrix * np.outer(scale, scale), 1e-14, hermitian=True)
        covariance *= np.outer(scale, scale)
        return cls(covariance, -covariance @ (rows @ near / variance + pull), alike)

    @property
    def lens(self):
        """Covariance (LENS, LENS) of the lens's parameters about those of the vector: that of
        flaws that were left out includes how far from zero the points would put them."""
        step = self.step[:LENS]
        return self.covariance[:LENS, :LENS] + np.outer(step, step)


def shown(estimate, vector):
    """Names of the :data:`FLAWS` that the points show.

    Beginning with all flaws, the one that explains least is left out as long as it explains
    less than chance does. That is Akaike's criterion.

    Parameters
    ----------
    estimate : Estimate
        At ``vector``, the parameters of a fit with all flaws.
    """
    value, covariance = vector + estimate.step[:len(vector)], estimate.covariance
    value, covariance, left = value[:LENS].copy(), covariance[:LENS, :LENS].copy(), dict(FLAWS)
    while left:
        weights = {}
        for name, numbers in left.items():
            part = np.ix_(numbers, numbers)
            weights[name] = value[list(numbers)] @ np.linalg.solve(
                covariance[part], value[list(numbers)]) / len(numbers)
        name = min(weights, key=weights.get)
        if weights[name] >= _WORTH:
            break
        numbers = list(left.pop(name))
        gain = np.linalg.solve(covariance[np.ix_(numbers, numbers)], covariance[numbers]).T
        value -= gain @ value[numbers]
        covariance -= gain @ covariance[numbers]
    return tuple(left)


def _alike(problem, rest, fitted):
    """The factor k of this module of residuals ``rest`` (n, 2), at least 1.

    ``fitted``: number of parameters that were fitted to them.
    """
    total, width = (rest**2).sum(), problem.size[0]
    most, photos = 1.0, problem.owner.max() + 1
    for cells in _CELLS:
        column, row = (problem.measured * cells / width).astype(int).clip(0).T
        of_picture = column + 4 * cells * row
        of_photo = of_picture * photos + problem.owner
        for group, parameters in ((of_picture, LENS), (of_photo, fitted)):
            _, number = np.unique(group, return_inverse=True)
            sums = np.stack([np.bincount(number, part) for part in rest.T])
            # What was fitted took away as much of the sums' freedom.
            free = 1 - parameters / sums.size
            if free > 0.25 and total > 0:
                most = max(most, (sums**2).sum() / total / free)
    return most
