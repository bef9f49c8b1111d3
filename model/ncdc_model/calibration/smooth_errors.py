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
from types import SimpleNamespace

import numpy as np

from ncdc_model.calibration.smooth_problem import ROBUST, SPREAD, deviation
from ncdc_model.calibration.smooth_vector import (
    DECENTRING,
    FLAWS,
    LENS,
    TERMS,
    lens_of,
    project,
)
from ncdc_model.lens import BrownWeng, KannalaBrandt

__all__ = ["Estimate", "forms", "shown"]

_CELLS = (4, 8, 16)    # cells across the picture, over which residuals are summed
_LEAST = 1e-3          # pixels: standard deviation of exact points
# Chi-square per parameter below which flaws are left out: Akaike's, times the root of k, since
# flaws would absorb a bent page, or an uneven lens.
_WORTH = 2.0
_FORMS = 6             # further terms of decentring and thin prism
_FORM, _TINY = 0.25, 1e-5       # their usual size, in parts of the decentring, and at least
_PROBE = 1e-5          # of such a term: step of a derivative


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
    variance : float
        k s^2 of this module, in square pixels.
    """
    covariance: np.ndarray
    step: np.ndarray
    alike: float
    variance: float

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
        return cls(covariance, -covariance @ (rows @ near / variance + pull),
                   alike, variance)

    @property
    def lens(self):
        """Covariance (LENS, LENS) of the lens's parameters about those of the vector: that of
        flaws that were left out includes how far from zero the points would put them."""
        step = self.step[:LENS]
        return self.covariance[:LENS, :LENS] + np.outer(step, step)


def forms(problem, vector):
    """Derivatives (8, 2 n) of the residuals by terms that the smooth lens lacks, and their usual
    sizes (8,): the form of a lens differs from one kind to the next.

    They are two further terms of the radial polynomial, and those of :class:`BrownWeng` times q
    and q^2. A lens whose decentring acts on ideal coordinates, as in OpenCV's model, has them.
    """
    lens, rays = lens_of(vector), problem.rays(vector)
    plain, rows = np.stack(project(lens, *rays), axis=1).ravel(), []

    def change(**parts):
        changed = SimpleNamespace(**vars(lens) | parts)
        rows.append((np.stack(project(changed, *rays), axis=1).ravel() - plain) / _PROBE)
    for further in ((_PROBE,), (0.0, _PROBE)):
        change(radial=KannalaBrandt((*lens.radial.k, *further)))
    for number in range(_FORMS):
        change(decentring=_Further(lens.decentring, number))
    along = _FORM * np.hypot(*vector[DECENTRING][:2]) + _TINY
    return np.nan_to_num(rows), np.array([SPREAD[2 + TERMS]] * 2 + [along] * _FORMS)


@dataclass(frozen=True)
class _Further:
    """A decentring ``base`` with a small further term, the ``number``-th."""
    base: BrownWeng
    number: int

    def distort(self, x, y):
        q = x * x + y * y
        terms = ((q + 2 * x * x) * q, 2 * x * y * q), (2 * x * y * q, (q + 2 * y * y) * q)
        (a, b), power = {0: (terms[0], 1), 1: (terms[1], 1), 2: (terms[0], q), 3: (terms[1], q),
                         4: ((q * q, 0 * q), 1), 5: ((0 * q, q * q), 1)}[self.number]
        xd, yd = self.base.distort(x, y)
        return xd + _PROBE * power * a, yd + _PROBE * power * b


def shown(problem, part, vector, prior):
    """The flaws that points show, and the fit with them alone.

    Beginning with all :data:`FLAWS`, each is left out if that costs no more chi-square than noise
    would: Akaike's criterion, made stricter where residuals are alike.

    Parameters
    ----------
    problem, part : Problem
        All points, and some of them, to which the fits are made.
    vector : ndarray
        Parameters near those of a fit with all flaws.
    prior : float
        Its weight of the prior.

    Returns
    -------
    (flaws, vector)
    """
    flaws, centred = tuple(FLAWS), vector.copy()
    # A decentring that its higher terms reverse is another minimum.
    centred[DECENTRING] = 0
    vector, cost = min((part.solved(start, prior, flaws) for start in (vector, centred)),
                       key=lambda fit: fit[1])
    estimate = Estimate.of(problem, vector)
    worth = _WORTH * (estimate.alike if problem.owner.max() == 0 else np.sqrt(estimate.alike))
    every = len(problem.owner) / len(part.owner)
    for name in sorted(FLAWS, key=lambda name: _weight(estimate, vector, FLAWS[name])):
        others = tuple(other for other in flaws if other != name)
        found, without = part.solved(vector, prior, others)
        if 2 * every * (without - cost) < worth * len(FLAWS[name]) * estimate.variance:
            flaws, vector, cost = others, found, without
    return flaws, vector


def _weight(estimate, vector, numbers):
    """Chi-square per parameter by which parameters ``numbers`` differ from zero."""
    value = (vector + estimate.step[:len(vector)])[list(numbers)]
    return value @ np.linalg.solve(estimate.covariance[np.ix_(numbers, numbers)],
                                   value) / len(numbers)


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
