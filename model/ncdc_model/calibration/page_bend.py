"""A page that is bent: its smooth height, from photos of it from several sides.

One photo does not separate a bent page from a flaw of the lens: both move its points smoothly. Of
three photos from different sides a height moves the points along three directions, a flaw of the
lens along one. So each photo has a polynomial height of its own, since the dots of a page have no
numbers that several photos share. Lens, poses and heights are fitted jointly, and the height is
taken off if it is proven.
"""

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander

from ncdc_model.calibration.smooth_errors import Estimate, forms
from ncdc_model.calibration.smooth_problem import Problem
from ncdc_model.calibration.smooth_vector import FLAWS, camera_of, planes_of

__all__ = ["PHOTOS", "USUAL", "Bend", "bent_lenses", "estimate_of", "find_bend"]

USUAL = 0.001          # sag of a page that is taken as flat, in parts of the length that is seen
PHOTOS = 3             # fewer do not separate page and lens
_USUAL_BENT = 0.003    # the same of a page that may be bent
_DEGREES = 2, 6        # of the polynomial
_DENSE = 200           # points of each photo for the higher degree
_PROVEN = 4.0, 12.0    # chi-square per coefficient from which a height of that degree is proven
_LEAST = 1e-4           # of the length: a page of less sag is flat, whatever the chi-square
_MORE = 3.0            # ratio of chi-squares from which the higher degree is taken
_ODD = 2.0             # factor of residuals that are alike from which the higher degree is tried
_SOME, _MOST = 2000, 8000      # points of all photos that a search uses, and an estimate
_ROUNDS = 16
_SLOW = 3              # rounds after which a bend that explains nothing is given up
_DONE = 4e-6           # of the length: change of a coefficient below which the search ends
_GRAIN = 2.0**-16      # of the length: coefficients are multiples of it, on every machine


@dataclass(frozen=True)
class Bend:
    """Height of the page on each photo.

    Parameters
    ----------
    length : float
        Steps of the target along its longer side, as the photos show it.
    coefficients : ndarray, shape (photos, k)
        Of :func:`_columns`, in parts of ``length``.
    error : float
        Standard error of :meth:`sag`.
    """
    length: float
    coefficients: np.ndarray
    error: float = float("nan")

    def to_dict(self):
        """Plain numbers and lists, as in the points file."""
        return vars(self) | {"coefficients": self.coefficients.tolist()}

    @classmethod
    def from_dict(cls, table):
        """The bend of :meth:`to_dict`'s table."""
        return cls(float(table["length"]), np.array(table["coefficients"], np.float64),
                   float(table["error"]))

    def height(self, photo, index):
        """Steps (n,) by which the points ``index`` (n, 2) of a photo lie above the plane, towards
        the camera."""
        degree = next(degree for degree in _DEGREES
                      if _count(degree) == self.coefficients.shape[1])
        return self.length * (_columns(index, self.length, degree) @ self.coefficients[photo])

    def sag(self, indices):
        """Largest difference of heights on one photo, in parts of the length."""
        return max(float(np.ptp(self.height(k, index))) for k, index in enumerate(indices)
                   ) / self.length


def _length(indices):
    """Largest extent, in steps, of the points of any photo."""
    return float(max(np.ptp(index, axis=0).max() for index in indices))


def _columns(index, length, degree=_DEGREES[0]):
    """Height of the points ``index`` (n, 2) for each term of a bend, (n, k), in parts of
    ``length``: Chebyshev products of total degree 2 to ``degree``. A level or tilted page is part
    of the pose."""
    middle = (index.min(axis=0) + index.max(axis=0)) / 2
    p, q = (chebvander(part, degree) for part in ((index - middle) * 2 / length).T)
    return np.stack([p[:, m] * q[:, n] for m in range(degree + 1) for n in range(degree + 1 - m)
                     if m + n > 1], axis=1)


def _count(degree):
    return (degree + 1) * (degree + 2) // 2 - 3


def find_bend(size, photos, near):
    """:class:`Bend` that photos of a page prove, or None.

    Parameters
    ----------
    size : (int, int)
        Width and height of the photos.
    photos : sequence of (index, xy)
        Arrays (n, 2) of each photo.
    near : SmoothFit
        The fit of the points of a flat page.
    """
    if len(photos) < PHOTOS:
        return None
    dense = min(len(xy) for _, xy in photos) >= _DENSE
    length, part = _length([index for index, _ in photos]), Problem(size, photos).part(_SOME)
    some = list(zip(part.indices, part.points))
    best, most = None, 0.0
    # A bulge hardly shows in the lowest degree, but in residuals that are alike.
    odd = Estimate.of(part, near.vector).alike > _ODD
    for degree, proven in zip(_DEGREES, _PROVEN):
        if degree > _DEGREES[0] and not (dense and (best or odd)):
            break
        bend, chi = _fitted(size, some, near, length, degree)
        if (chi > max(proven * bend.coefficients.size, _MORE * most)
                and bend.sag([index for index, _ in some]) > _LEAST):
            best, most = bend, chi
    return best


def _fitted(size, photos, near, length, degree):
    """The :class:`Bend` of a ``degree`` that explains the photos best, and its chi-square."""
    terms = [_columns(index, length, degree) for index, _ in photos]
    value = np.zeros((len(photos), terms[0].shape[1]))
    for turn in range(_ROUNDS):
        bend = Bend(length, value)
        flat = Problem(size, [(index, xy - near.raised(k, index, bend.height(k, index)))
                              for k, (index, xy) in enumerate(photos)])
        near = _lens(size, flat.solved(near.vector, near.prior, tuple(FLAWS))[0], near)
        moves = _moves(near, photos, terms, length)
        estimate = Estimate.of(flat, near.vector, moves, [_USUAL_BENT] * len(moves))
        step = estimate.step[len(near.vector):].reshape(value.shape)
        value = value + step
        covariance = estimate.covariance[len(near.vector):, len(near.vector):]
        chi = float(value.ravel() @ np.linalg.solve(covariance, value.ravel()))
        if np.abs(step).max() < _DONE or turn >= _SLOW and chi < value.size:
            break
    return Bend(length, np.rint(value / _GRAIN) * _GRAIN, _error(value, covariance, terms)), chi


def _lens(size, vector, near):
    """:class:`SmoothFit` of a ``vector``, otherwise like ``near``."""
    return replace(near, camera=camera_of(vector, size), planes=tuple(planes_of(vector)),
                   vector=vector)


def estimate_of(size, photos, fit):
    """:class:`Estimate` of a fit of ``photos``, whose page may have a cylinder's and a saddle's
    bend of :data:`USUAL` size on each, and whose lens may have the terms of :func:`forms`."""
    every = Problem(size, photos)
    problem = every.part(_MOST)
    some = list(zip(problem.indices, problem.points))
    length = _length(problem.indices)
    moves = _moves(fit, some, [_columns(index, length) for index in problem.indices], length)
    further, sizes = forms(problem, fit.vector)
    return Estimate.of(problem, fit.vector, np.concatenate([moves, further]),
                       [*[USUAL] * len(moves), *sizes], len(problem.owner) / len(every.owner))


def bent_lenses(size, indices, fit, sag):
    """The lenses that would be fitted in place of ``fit`` if the page was bent by ``sag``, in
    parts of its extent, and taken as flat: to a cylinder along its columns, and along its rows.

    Returns
    -------
    list of Camera
    """
    found = []
    for axis in (0, 1):
        photos = []
        for k, index in enumerate(indices):
            along, extent = index[:, axis] - np.ptp(index[:, axis]) / 2, np.ptp(index[:, axis])
            height = 4 * sag * (along - index[:, axis].min())**2 / max(extent, 1)
            photos.append((index, fit.pixels(k, index) + fit.raised(k, index, height)))
        vector, _ = Problem(size, photos).part().solved(fit.vector, fit.prior, fit.flaws)
        found.append(camera_of(vector, size))
    return found


def _moves(fit, photos, terms, length):
    """Derivatives (b, 2 n) of the points' pixels by every coefficient of a bend, whose ``terms``
    each photo has."""
    counts = [len(index) for index, _ in photos]
    moves = np.zeros((len(photos), terms[0].shape[1], sum(counts), 2))
    for k, (end, count) in enumerate(zip(np.cumsum(counts), counts)):
        moves[k, :, end - count:end] = (length * terms[k].T)[:, :, None] * fit.normal(
            k, photos[k][0])
    return moves.reshape(-1, 2 * sum(counts))


def _error(value, covariance, terms):
    """Standard error of the largest difference of heights, in parts of the length."""
    heights = [part @ row for part, row in zip(terms, value)]
    k = int(np.argmax([np.ptp(height) for height in heights]))
    along = terms[k][heights[k].argmax()] - terms[k][heights[k].argmin()]
    part = slice(k * len(along), (k + 1) * len(along))
    return float(np.sqrt(max(along @ covariance[part, part] @ along, 0.0)))
