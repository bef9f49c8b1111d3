"""How far the points determine the lens: a fit with every term that lenses are known to have.

The smooth lens of :mod:`ncdc_model.calibration.smooth` is one choice among the lenses that explain
the points: four terms of an equidistant polynomial, and flaws only where they are proven. Between
the points all choices agree. Beyond the outermost ones they part. So the lens is fitted once more,
with twice the radial terms and with all flaws. Each has the size that it has in known families
of lenses: perspective with Brown's or a rational polynomial, equidistant, equisolid, stereographic,
orthographic, division model. The covariance of this fit is what the points leave open.
"""

from copy import copy
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.polynomial import chebyshev

from ncdc_model.calibration.descent import descend
from ncdc_model.calibration.smooth_derivatives import derivatives
from ncdc_model.calibration.smooth_vector import LENS, TERMS, lens_of, planes_of, project
from ncdc_model.lens import BrownWeng, KannalaBrandt
from ncdc_model.training.problem import spread

__all__ = ["FreeLens", "free_lens"]

_RADIAL = 8            # odd Chebyshev polynomials of the angle, from the third degree on
# Their usual size over the radius at the largest angle: of the first, and of each over the one
# before. Those of the families fall by a factor of 3 to 7.
_FIRST, _FALL = 0.06, 0.3
_FORM = 4              # further terms: two of the decentring, one of the thin prism on each axis
_SIZED, _FORMED = slice(3, 3 + _RADIAL), slice(3 + _RADIAL, 3 + _RADIAL + _FORM)   # of the vector
_ANGLES = 60           # at which the nearest smooth lens is found
_SHARED = LENS - TERMS + _RADIAL + _FORM  # parameters but those of the poses
# Usual sizes of the others: focal length (its logarithm, in widths), centre (in widths), the
# further terms, decentring and its higher terms, thin prism, tilt, aspect, ratio of the target's
# distances.
_SIZES = np.array([0.4, 0.05, 0.05, *_FIRST * _FALL ** np.arange(_RADIAL), 0.7, 0.5, 0.003, 0.003,
                   0.005, 0.005, 1.0, 1.0, 0.003, 0.003, 0.05, 0.05, 0.03, 0.01])
_MIDDLE = np.log(0.5)  # of the focal length's logarithm
_SOME = 500            # points that are used
_ROBUST = 6.0          # standard deviations: larger residuals count linearly
_NOISE = 0.01          # pixels: no points are better
_ROUNDS = 3            # of fits, each with the noise that the previous one left
_SETTLED = 0.8         # of the noise before: with less the fit is repeated
_STEP = 1e-4           # of the cost: a fit's last step


@dataclass(frozen=True)
class FreeLens:
    """A lens fitted with all terms free, and how far it is determined.

    Parameters
    ----------
    radial : _Radial
        What its radial parameters mean.
    vector : ndarray
        Logarithm of the focal length, centre, radial parameters, two more terms of the decentring
        and the higher ones of the thin prism, then as in
        :mod:`ncdc_model.calibration.smooth_vector`.
    modes : ndarray, shape (m, m)
        Independent changes of all parameters but those of the poses, each of the size of its
        standard deviation: the roots of their covariance.
    turn : ndarray, shape (3, 3)
        Takes directions (a, b, 1) of the frame's camera to those of this lens.
    known : ndarray, shape (k, 3)
        Directions of points that the lens was fitted to.
    seen : ndarray, shape (n, 2)
        Distorted pixels of the frame's points by this lens, each in its own photo's pose.
    """
    radial: "_Radial"
    vector: np.ndarray
    modes: np.ndarray
    turn: np.ndarray
    known: np.ndarray
    seen: np.ndarray

    def pixels(self, a, b):
        """Distorted pixels (n, 2) of ideal points (a, b) of the frame's camera."""
        return self.radial.seen(self.vector, self._rays(a, b))

    def deviation(self, a, b):
        """Standard deviation (n,) of x, and of y, of the pixels of ideal points.

        A homography of the flat picture is free: of each mode that is taken off which moves the
        points least.
        """
        moved, turned = self._moved(self._rays(a, b))
        left = moved - turned @ self._free
        return np.sqrt((left**2).sum(axis=(1, 2)) / 2)

    @cached_property
    def _free(self):
        """The homography (9, m) of each mode."""
        moved, turned = self._moved(self.known)
        return np.linalg.lstsq(turned.reshape(-1, 9), moved.reshape(-1, moved.shape[2]),
                               rcond=1e-12)[0]

    def _moved(self, rays):
        """How the pixels of directions move with each mode (n, 2, m), and with each number of a
        homography (n, 2, 9)."""
        level = np.concatenate([self.vector[:_SHARED], [0, 0, 0, 0, 0, 1.0]])
        level[_SHARED - 1] = 0          # the ratio of a target's distances: here is none
        ideal = rays[:, :2] / rays[:, 2:]
        slopes = self.radial.slopes(level, ideal, np.zeros(len(rays), int))
        by_ray = slopes[:, :, -3:, None] * np.insert(ideal, 2, 1, axis=1)[:, None, None]
        return slopes[:, :, :_SHARED] @ self.modes, by_ray.reshape(len(rays), 2, 9)

    def _rays(self, a, b):
        return np.stack([a, b, np.ones_like(a)], axis=1) @ self.turn.T


def free_lens(frame, largest):
    """:class:`FreeLens` of the points of an :class:`~ncdc_model.calibration.frame.IdealFrame`.

    ``largest``: the largest view angle, in radians, at which the lens is asked for.
    """
    whole = _Problem(frame, largest)
    problem = whole.part()
    vector, noise = problem.start, None
    for _ in range(_ROUNDS):
        now = max(_usual(problem.errors(vector)), _NOISE)
        if noise is not None and not now < _SETTLED * noise:
            break
        noise, vector = now, problem.solved(vector, now)
    turn = problem.turn(vector)
    return FreeLens(problem.radial, vector, problem.modes(vector, noise), turn,
                    problem.rays @ turn.T, whole.errors(vector) + whole.xy)


class _Problem:
    """The points of a frame, and the lenses that may explain them."""

    def __init__(self, frame, largest):
        fit = frame.fits[-1].vector
        self.owner, self.xy = frame.photo, frame.distorted
        self.size = np.array(frame.camera.size, np.float64)
        a, b = frame.camera.frame.ideal(*frame.corrected.T)
        self.rays = np.column_stack([a, b, np.ones(len(a))])
        cells = np.linalg.solve(planes_of(fit)[self.owner], self.rays[:, :, None])[:, :, 0]
        self.cells = cells[:, :2] / cells[:, 2:]
        self.radial = _Radial(largest)
        radial = np.linalg.solve(self.radial.terms, np.pad(fit[3:3 + TERMS], (0, _RADIAL - TERMS)))
        self.start = np.concatenate([[np.log(fit[0])], fit[1:3], radial, np.zeros(_FORM),
                                     fit[3 + TERMS:]])
        self.sizes = _SIZES * np.where(np.isin(np.arange(_SHARED), (1, 2)), self.size[0], 1)
        self.means = np.zeros(_SHARED)
        self.means[:3] = _MIDDLE + np.log(self.size[0]), *(self.size - 1) / 2

    def part(self):
        """The problem with some of the points, of all photos."""
        result, some = copy(self), spread(len(self.xy), _SOME)
        result.owner, result.xy = self.owner[some], self.xy[some]
        result.rays, result.cells = self.rays[some], self.cells[some]
        return result

    def errors(self, vector):
        """Pixels (n, 2) from the points to where the lens sees them."""
        return np.nan_to_num(self.radial.seen(vector, _rays(vector, self.cells, self.owner))
                             - self.xy, nan=1e4)

    def solved(self, vector, noise):
        """The likeliest lens, by points of a ``noise`` in pixels, near that of ``vector``."""
        return descend(lambda v: self._residuals(v, noise), lambda v: self._slopes(v, noise),
                       vector, _ROBUST, _STEP)[0]

    def modes(self, vector, noise):
        """Roots (m, m) of the covariance of the parameters that all photos share."""
        slopes = self._slopes(vector, noise)
        used = slopes * (np.abs(self._residuals(vector, noise)) < _ROBUST)
        scale = np.sqrt((used**2).sum(axis=1))
        values, vectors = np.linalg.eigh(used @ slopes.T / scale / scale[:, None])
        roots = vectors / scale[:, None] / np.sqrt(np.maximum(values, 1e-14 * values[-1]))
        return np.linalg.qr(roots[:_SHARED].T, mode="r").T

    def turn(self, vector):
        """The homography from the frame's directions to those of the lens of ``vector``."""
        goal = _rays(vector, self.cells, self.owner)
        goal, nothing = goal / np.linalg.norm(goal, axis=1, keepdims=True), np.zeros_like(self.rays)
        x, y, z = (part[:, None] * self.rays for part in goal.T)
        system = np.vstack([np.hstack([nothing, -z, y]), np.hstack([z, nothing, -x]),
                            np.hstack([-y, x, nothing])])
        matrix = np.linalg.svd(system, full_matrices=False)[2][-1].reshape(3, 3)
        return matrix * np.sign(((self.rays @ matrix.T) * goal).sum())

    def _residuals(self, vector, noise):
        return np.concatenate([self.errors(vector).ravel() / noise,
                               (vector[:_SHARED] - self.means) / self.sizes])

    def _slopes(self, vector, noise):
        slopes = self.radial.slopes(vector, self.cells, self.owner).reshape(-1, len(vector))
        prior = np.eye(_SHARED, len(vector)) / self.sizes[:, None]
        return np.concatenate([np.nan_to_num(slopes) / noise, prior]).T


class _Radial:
    """The radial terms: odd Chebyshev polynomials over angles up to ``largest``, but their linear
    parts, which the focal length has.

    ``terms`` takes their sizes to the coefficients of theta**3, theta**5, ...; ``near`` takes them
    to the four coefficients of the nearest smooth lens.
    """

    def __init__(self, largest):
        self.terms = np.zeros((_RADIAL, _RADIAL))
        powers = largest ** (2.0 * np.arange(1, _RADIAL + 1))
        for k in range(_RADIAL):
            polynomial = chebyshev.cheb2poly([0] * (2 * k + 3) + [1])
            self.terms[:k + 1, k] = polynomial[3::2] / powers[:k + 1]
        angle = largest * np.sqrt((np.arange(_ANGLES) + .5) / _ANGLES)
        all_powers = angle[:, None] ** (3 + 2.0 * np.arange(_RADIAL))
        self.near = np.linalg.lstsq(all_powers[:, :TERMS], all_powers @ self.terms, rcond=None)[0]

    def seen(self, vector, rays):
        """Distorted pixels (n, 2) of directions (n, 3)."""
        lens = lens_of(_flat(vector, np.zeros(TERMS)))
        lens.radial = KannalaBrandt(tuple((self.terms @ vector[_SIZED]).tolist()))
        p4, p5, s1, s3 = vector[_FORMED].tolist()
        s0, _, s2, _ = lens.decentring.s
        lens.decentring = BrownWeng(p=(*lens.decentring.p, p4, p5), s=(s0, s1, s2, s3))
        return np.stack(project(lens, *rays.T), axis=1)

    def slopes(self, vector, cells, owner):
        """Derivatives (n, 2, parameters) of the pixels of points of targets, by the nearest smooth
        lens."""
        near = self.near @ vector[_SIZED]
        rows = derivatives(_flat(vector, near), cells, owner).transpose(1, 2, 0)
        x, y, z = _rays(vector, cells, owner).T
        angle = np.arctan2(np.hypot(x, y), z)
        by_power = angle[:, None] ** (2.0 * np.arange(_RADIAL))
        by_size = rows[:, :, 3, None] * (by_power @ self.terms)[:, None]
        q = (angle * (1 + by_power[:, 1:TERMS + 1] @ near))[:, None, None] ** 2
        p3, s0, s2 = (rows[:, :, [k + TERMS]] for k in (6, 7, 8))
        return np.concatenate([rows[:, :, :1] * np.exp(vector[0]), rows[:, :, 1:3], by_size,
                               p3 * q, p3 * q * q, s0 * q, s2 * q, rows[:, :, 3 + TERMS:]], axis=2)


def _flat(vector, radial):
    """The vector of :mod:`smooth_vector` with ``radial`` terms, without the further ones."""
    return np.concatenate([[np.exp(vector[0])], vector[1:3], radial, vector[_FORMED.stop:]])


def _rays(vector, cells, owner):
    """Directions (n, 3) of points of targets."""
    planes = planes_of(_flat(vector, np.zeros(TERMS)))[owner]
    return (planes[:, :, :2] @ cells[:, :, None])[:, :, 0] + planes[:, :, 2]


def _usual(errors):
    """Usual error on one axis; few large ones do not count."""
    middle = 1.4826 * np.median(np.abs(errors))
    return float(np.sqrt(np.mean(np.minimum(np.abs(errors), _ROBUST * middle)**2)))
