"""Fits a smooth camera to the points of photos of a flat target."""

import numpy as np

from ncdc_model.calibration.descent import descend
from ncdc_model.calibration.smooth_derivatives import derivatives
from ncdc_model.calibration.smooth_vector import (
    FLAWS,
    LENS,
    TERMS,
    fixed,
    guess,
    lens_of,
    planes_of,
    project,
)

__all__ = ["MIN_POINTS", "ROBUST", "SPREAD", "Problem", "deviation"]

MIN_POINTS = 12        # of a photo: its pose has six unknowns, the lens has nine more
_FOCALS = (0.3, 0.45, 0.7, 1.1)     # first guesses, in image widths
_ASPECTS = (0.92, 1.0, 1.08)        # and of the pixels
ROBUST = 0.5           # pixels: larger residuals count linearly

# One photo does not separate an asymmetric lens from a tilted page, nor a long lens near the page
# from a short one far away: a prior decides. Mean and standard deviation of the focal length (its
# logarithm, in widths), the centre (from the middle, in widths) and the others in the order of the
# vector. Photos from several sides determine the lens; then the prior has little weight.
_MEAN = np.array([np.log(0.5)] + [0.0] * (LENS - 1))
SPREAD = np.array([0.4] + [0.03] * 2 + [0.15] * TERMS + [0.002] * 2 + [0.5] * 2 + [0.002] * 2
                   + [0.1] * 2 + [0.05, 0.01])
_ALONE, _TOGETHER = 1 / 128, 1 / 1280     # of the width: residual of one deviation
# Of the width: residual of a lens that is not smooth. With smaller residuals the points determine
# the lens, and the prior's weight is reduced in proportion, down to its minimum. Only the prior
# determines the higher terms of a very small decentring.
_LEFT = 1 / 2000
_MIN_PRIOR = np.array([0.01] * (5 + TERMS) + [0.1] * 2 + [0.01] * 6)
_GRAIN = 4             # steps of the prior's weight from one to its half
_SETTLED = 0.8         # of the prior's last weight: with less the fit is repeated
_SOME = 600            # points of all photos that are used in a search
_ROUNDS = 6            # of fits, each with the prior's weight from the residual of the previous one
_STARTS = 3            # guesses from which a lens with flaws is searched


def deviation(vector, size):
    """Deviation (LENS,) of a vector's lens from the mean of the prior, in its units."""
    lens = vector[:LENS].copy()
    lens[0] = np.log(max(lens[0], 1.0) / size[0])
    lens[1:3] = (lens[1:3] - (np.array(size) - 1) / 2) / size[0]
    return lens - _MEAN


class Problem:
    """Residuals of a vector of parameters at the points of photos."""

    def __init__(self, size, photos):
        self.size = size
        self.indices = [np.asarray(index, np.float64) for index, _ in photos]
        self.points = [np.asarray(xy, np.float64) for _, xy in photos]
        self.measured = np.concatenate(self.points)
        self.cells = np.concatenate(self.indices)
        self.owner = np.repeat(np.arange(len(photos)), [len(xy) for xy in self.points])
        self.prior_scale = size[0] * max(_ALONE / len(photos)**2, _TOGETHER) / SPREAD

    def part(self, some=_SOME):
        """The problem with ``some`` points of all photos; as many as by default suffice for a
        search."""
        limit, rng = max(some // len(self.points), MIN_POINTS), np.random.default_rng(1)
        chosen = [rng.permutation(len(xy))[:limit] for xy in self.points]
        return Problem(self.size, [(index[some], xy[some]) for index, xy, some in
                                   zip(self.indices, self.points, chosen)])

    def errors(self, vector):
        """Pixels (2 n,) from each point to its projection."""
        i, j = self.cells.T
        planes = planes_of(vector)[self.owner]
        rays = (planes[:, axis, 0] * i + planes[:, axis, 1] * j + planes[:, axis, 2]
                for axis in range(3))
        off = np.stack(project(lens_of(vector), *rays), axis=1) - self.measured
        return np.nan_to_num(off.ravel(), nan=1e4)

    def residuals(self, vector, prior=1.0):
        """Errors, and ``prior`` times the deviation from the prior."""
        return np.concatenate([self.errors(vector),
                               self._weight(prior) * deviation(vector, self.size)])

    def derivatives(self, vector, prior=1.0, flaws=tuple(FLAWS)):
        """Derivatives of the residuals by each parameter: a row each, of zeros for the parameters
        of a camera without the other :data:`~ncdc_model.calibration.smooth_vector.FLAWS`."""
        points = 2 * len(self.owner)
        rows = np.zeros((len(vector), points + LENS))
        rows[:, :points] = derivatives(vector, self.cells, self.owner).reshape(len(vector), -1)
        rows[np.arange(LENS), points + np.arange(LENS)] = self._weight(prior) * self.units(vector)
        rows[fixed(flaws)] = 0
        return np.nan_to_num(rows, copy=False)

    def units(self, vector):
        """Derivatives (LENS,) of :func:`deviation` by the parameters."""
        scale = np.ones(LENS)
        scale[:3] = (vector[0] > 1) / max(vector[0], 1.0), 1 / self.size[0], 1 / self.size[0]
        return scale

    def _weight(self, prior):
        return np.maximum(prior, _MIN_PRIOR) * self.prior_scale

    def solved(self, start, prior=1.0, flaws=()):
        """Vector and cost of a robust fit from ``start``, where the other flaws are zero."""
        start = start.copy()
        start[fixed(flaws)] = 0
        return descend(lambda vector: self.residuals(vector, prior),
                       lambda vector: self.derivatives(vector, prior, flaws), start, ROBUST)

    def searched(self, enough=0.0):
        """Vector of the best fit, weight of the prior in it, and its flaws: all of them, or none.

        ``enough``: pixels of the usual residual on one axis, below which no flaws are looked for.
        """
        def usual(vector):
            return np.median(np.abs(self.residuals(vector)))
        guesses = sorted((min((guess(self.size, focal * self.size[0], aspect, self.indices,
                                     self.points) for aspect in _ASPECTS), key=usual)
                          for focal in _FOCALS), key=usual)
        if enough:
            best, _ = min(map(self.solved, guesses[:2]), key=lambda found: found[1])
            plain = self.settled(best, ())
            if self._left(plain[0]) < enough:
                return *plain, ()
        # Without its flaws first, a lens with pixels that are not square ends in other minima.
        found = [self.solved(guess, 1.0, tuple(FLAWS)) for guess in guesses[:_STARTS]]
        return *self.settled(min(found, key=lambda fit: fit[1])[0], tuple(FLAWS)), tuple(FLAWS)

    def settled(self, vector, flaws):
        """Vector of the fit from ``vector``, and weight of the prior, which follows the residual.
        """
        prior = 1.0
        for _ in range(_ROUNDS):
            # Rounded: the last digits of a fit differ from machine to machine.
            weight = 2.0**(np.rint(_GRAIN * np.log2(self._left(vector) / (_LEFT * self.size[0])))
                           / _GRAIN)
            now = float(np.clip(weight, _MIN_PRIOR.min(), 1.0))
            if not now < _SETTLED * prior:
                break
            prior, (vector, _) = now, self.solved(vector, now, flaws)
        return vector, prior

    def _left(self, vector):
        """Median residual on one axis, in pixels."""
        return float(np.median(np.abs(self.errors(vector))))
