"""Points of photos of a flat target, and the smooth camera that explains them best."""

import numpy as np
from scipy.optimize import least_squares

from ncdc_model.calibration.smooth_vector import FLAWS, LENS, TERMS, guess, project, unpack

__all__ = ["MIN_POINTS", "ROBUST", "Problem"]

MIN_POINTS = 12        # of a photo: its pose has six unknowns, the lens has nine more
_FOCALS = (0.3, 0.45, 0.7, 1.1)     # first guesses, in image widths
ROBUST = 0.5           # pixels: residuals beyond count linearly

# One photo cannot tell an asymmetric lens from a tilted page, nor a long lens near the page from a
# short one far away: what is usual of a lens decides. Mean and standard deviation of the focal
# length (its logarithm, in widths), the centre (from the middle, in widths) and the others in the
# order above. Photos from several sides do tell; then the usual counts for little.
_MEAN = np.array([np.log(0.5)] + [0.0] * (LENS - 1))
_SPREAD = np.array([0.4] + [0.03] * 2 + [0.15] * TERMS + [0.002] * 2 + [0.5] * 2 + [0.002] * 2
                   + [0.02] * 2 + [0.02, 0.01])
_ALONE, _TOGETHER = 1 / 128, 1 / 1280     # of the width: what one deviation weighs in a residual
# Of the width: what a lens that is not smooth leaves. Where less is left the points tell the lens,
# and the usual weighs less in proportion, down to its least part. Nothing but the usual tells the
# higher terms of a decentring that is hardly there.
_LEFT = 1 / 2000
_LEAST = np.array([0.01] * (5 + TERMS) + [0.1] * 2 + [0.01] * 6)
# The flaws are believed only where they explain most of what is left without them: else they would
# take up a bent page, or an uneven lens.
_EXPLAINS = 1.0, 0.4
_SETTLED = 0.8         # of what the usual weighed: if less is due the fit is made again
_BLOCK = 1 << 15       # numbers that are worked on at a time
_PROBE = 1e-6          # of a parameter: by which it is moved for a derivative
_SOME = 600            # points of all photos that a search is made on
_ROUNDS = 6            # of fits, each weighing the usual by what the one before has left


class Problem:
    """Points of photos, and how far a vector of parameters is from them."""

    def __init__(self, size, photos):
        self.size = size
        self.indices = [np.asarray(index, np.float64) for index, _ in photos]
        self.points = [np.asarray(xy, np.float64) for _, xy in photos]
        self.measured = np.concatenate(self.points)
        self.cells = np.concatenate(self.indices)
        self.owner = np.repeat(np.arange(len(photos)), [len(xy) for xy in self.points])
        self.usual = size[0] * max(_ALONE / len(photos)**2, _TOGETHER) / _SPREAD

    def part(self):
        """The problem of some of each photo's points: a search needs no more."""
        most, rng = max(_SOME // len(self.points), MIN_POINTS), np.random.default_rng(1)
        chosen = [rng.permutation(len(xy))[:most] for xy in self.points]
        return Problem(self.size, [(index[some], xy[some]) for index, xy, some in
                                   zip(self.indices, self.points, chosen)])

    def errors(self, vectors):
        """Pixels (..., 2 n) from each point to its projection, of vectors (..., m)."""
        lens, planes = unpack(vectors)
        i, j = self.cells.T
        rays = (planes[..., self.owner, axis, 0] * i + planes[..., self.owner, axis, 1] * j
                + planes[..., self.owner, axis, 2] for axis in range(3))
        off = np.stack(project(lens, *rays), axis=-1) - self.measured
        return np.nan_to_num(off.reshape(*off.shape[:-2], -1), nan=1e4)

    def residuals(self, vectors, doubt=1.0):
        """The errors, and ``doubt`` times how unusual the lens is, of vectors (..., m)."""
        lens = vectors[..., :LENS].copy()
        lens[..., 0] = np.log(np.maximum(lens[..., 0], 1.0) / self.size[0])
        lens[..., 1:3] = (lens[..., 1:3] - (np.array(self.size) - 1) / 2) / self.size[0]
        unusual = np.maximum(doubt, _LEAST) * self.usual * (lens - _MEAN)
        return np.concatenate([self.errors(vectors), unusual], axis=-1)

    def derivatives(self, vector, steps, doubt=1.0, flawed=True):
        """Of the residuals by each parameter, moved by its of ``steps`` to either side: a row each,
        of zeros for the flaws of a camera that is not ``flawed``.

        A photo's pose moves its own points only, so that those of all photos are moved together.
        """
        points, poses = 2 * len(self.owner), LENS + np.arange(6)
        probes = [*np.flatnonzero(~FLAWS | flawed), *poses]
        moves = np.zeros((len(probes), len(vector)))
        for move, number in zip(moves, probes):
            which = slice(number, None, 6) if number >= LENS else number
            move[which] = steps[which]
        most = max(1, _BLOCK // points)
        moved = np.concatenate([
            (self.residuals(vector + part, doubt) - self.residuals(vector - part, doubt)) / 2
            for part in (moves[k:k + most] for k in range(0, len(moves), most))])
        rows = np.zeros((len(vector), moved.shape[1]))
        rows[probes[:-6]] = moved[:-6] / steps[probes[:-6]][:, None]
        own = np.repeat(6 * self.owner, 2)
        for move, number in zip(moved[-6:], poses):
            rows[number + own, np.arange(points)] = move[:points] / steps[number + own]
        return rows

    def solved(self, start, doubt=1.0, flawed=False):
        """Result of a robust least squares from ``start``."""
        return least_squares(
            self.residuals, start, lambda vector, doubt: self.derivatives(
                vector, _PROBE * np.maximum(np.abs(vector), 1e-3), doubt, flawed).T,
            method="dogbox", x_scale="jac", loss="huber", f_scale=ROBUST, max_nfev=100, ftol=1e-6,
            args=(doubt,))

    def searched(self):
        """Vector of the best fit, how much the usual counts in it, and whether it has flaws."""
        guesses = sorted((guess(self.size, focal * self.size[0], self.indices, self.points)
                          for focal in _FOCALS),
                         key=lambda guess: np.median(np.abs(self.residuals(guess))))
        best = min(map(self.solved, guesses[:2]), key=lambda result: result.cost)
        plain = self._refined(best, False)
        flawed = self._refined(self.solved(plain[0], 1.0, True), True)
        return min((plain, flawed), key=lambda fit: self._left(fit[0]) / _EXPLAINS[fit[2]])

    def _refined(self, best, flawed):
        """:meth:`searched` from the result ``best``; the usual counts for less where less is left.
        """
        doubt = 1.0
        for _ in range(_ROUNDS):
            now = float(np.clip(self._left(best.x) / (_LEFT * self.size[0]), _LEAST.min(), 1.0))
            if not now < _SETTLED * doubt:
                break
            doubt, best = now, self.solved(best.x, now, flawed)
        return best.x, doubt, flawed

    def _left(self, vector):
        """What a lens usually leaves on one axis, in pixels."""
        return float(np.median(np.abs(self.errors(vector))))
