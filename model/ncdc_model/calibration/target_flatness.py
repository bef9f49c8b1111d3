"""Relief of a target that is not flat: displacements along the projection of its normal."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander

__all__ = ["Relief", "find_relief", "line_scatter", "polynomial"]

_DEGREES = (3, 5, 7, 9, 11)   # of the polynomial by which the lens may differ from the smooth one
_BETTER = 0.97         # a higher degree must reduce the error to this part of it
_FOLDS = 5
_MIN_POINTS = 200           # of a photo, below which no relief is looked for
_DENSE = 200           # the same, for their scatter
_LONGER = 1.5          # ratio of the rms along the normal to that across it: more may be relief
_KNOWN = 0.6           # of the rms along the normal: the most that neighbours may fail to predict
_WINDOWS = ((2, 2), (3, 1), (1, 3), (4, 0), (0, 4))   # columns and rows to either side
_ROUNDS = 20           # of fitting lens and relief in turn
_SHRINK = 0.3          # weight of the prior that neighbours are alike


@dataclass(frozen=True)
class Relief:
    """Effect of the target's shape on one photo.

    Parameters
    ----------
    along : ndarray, shape (n, 2)
        Unit vectors in the picture: directions of a displacement along the target's normal.
    shift : ndarray, shape (n, 2)
        Pixels by which the relief displaces the points, each estimated from its neighbours
        alone; zeros if there is no relief.
    degree : int
        Degree of the polynomial in column and row that describes the rest of the lens.
    found : bool
        Whether there may be relief.
    height : ndarray, shape (n,)
        Height of the target at its points, in steps; the shift is that times the normal.
    """
    along: np.ndarray
    shift: np.ndarray
    degree: int
    found: bool
    height: np.ndarray

    @property
    def flat(self):
        """The same with the target taken as flat."""
        return replace(self, shift=np.zeros_like(self.shift), found=False,
                       height=np.zeros_like(self.height))


def find_relief(index, residual, normal):
    """Possible relief of a target, from one photo of it.

    A lens displaces the points of a small area by the same amount in any direction. A dent of the
    target displaces them only along the projection of its normal. So the lens is a polynomial in
    column and row, of the degree that best predicts held-out residuals *across* the normal.
    Residuals *along* the normal are relief if they are much larger than those across it and the
    neighbours of a point predict them.

    A smooth bend of the target cannot be separated from a flaw of the lens: it counts as lens. A
    lens flaw along the normal looks like relief, so that one photo is no proof
    (:mod:`ncdc_model.calibration.same_relief`).

    Parameters
    ----------
    index : ndarray, shape (n, 2)
    residual : ndarray, shape (n, 2)
        Measured pixels minus those of the smooth lens.
    normal : ndarray, shape (n, 2)
        Pixels by which a point moves for a step along the target's normal.

    Returns
    -------
    Relief
    """
    length = np.linalg.norm(normal, axis=1, keepdims=True)
    along = normal / np.maximum(length, 1e-12)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    degree = _degree(index, residual, across)
    nothing = Relief(along, np.zeros_like(residual), degree, False, np.zeros(len(index)))
    if len(index) < _MIN_POINTS:
        return nothing
    basis = np.linalg.qr(polynomial(index, degree))[0]

    def left(values):
        return values - basis @ (basis.T @ values)
    rest = left(residual)
    if _rms(rest * along) < _LONGER * _rms(rest * across):
        return nothing
    # A dent displaces points by its height times the normal: smooth the height, not the pixels.
    scale = np.maximum(length, 0.1 * np.median(length))
    best = None
    for window in _WINDOWS:
        others, smooth = _smoother(index, window)
        height = np.zeros((len(index), 1))
        for _ in range(_ROUNDS):
            rest = left(residual - height * normal)
            height = height + (rest * along).sum(axis=1, keepdims=True) / scale
            height = (smooth * height[others, 0]).sum(axis=1, keepdims=True)
        error = _rms(left(residual - height * normal) * along)
        if best is None or error < best[0]:
            best = error, height
    error, height = best
    if error > _KNOWN * _rms(left(residual) * along):
        return nothing
    return Relief(along, height * normal, degree, True, height[:, 0])


def polynomial(index, degree):
    """Chebyshev products of total ``degree`` in column and row, each scaled to -1..1."""
    low, high = index.min(axis=0), index.max(axis=0)
    a, b = (2 * (index - low) / np.maximum(high - low, 1) - 1).T
    p, q = chebvander(a, degree), chebvander(b, degree)
    return np.stack([p[:, m] * q[:, n] for m in range(degree + 1) for n in range(degree + 1 - m)],
                    axis=1)


def line_scatter(index, xy, direction):
    """Distance (k,) of each point from the course of its line, along ``direction``, in pixels.

    Four neighbours in a row or column, two on either side, predict the fifth: a smooth lens does
    not contribute. The differences are divided by 1.39, since the four are uncertain too, so that
    their standard deviation is that of a single point. The result is empty if the photo has fewer
    than 200 points: their distances are so large that the lens would contribute.
    """
    scatter, steps = [], ((1, 0), (0, 1))
    if len(index) < _DENSE:
        return np.empty(0)
    if len(np.unique(np.sum(index, axis=1) % 2)) == 1:         # staggered
        steps = (1, 1), (1, -1)
    at = np.asarray(index) - np.min(index, axis=0) + 2
    number = np.full(at.max(axis=0) + 3, -1)
    number[tuple(at.T)] = np.arange(len(at))
    for step in np.array(steps):
        line = np.stack([number[tuple((at + k * step).T)] for k in (-2, -1, 1, 2)])
        on = (line >= 0).all(axis=0)
        a, b, c, d = xy[line[:, on]]
        scatter.append(((xy[on] - (4 * (b + c) - a - d) / 6) * direction[on]).sum(axis=1))
    return np.concatenate(scatter) / np.sqrt(1 + 34 / 36)


def _degree(index, residual, across):
    """Degree of the polynomial that predicts held-out residuals across the normal best."""
    measured = (residual * across).sum(axis=1)
    fold = np.random.default_rng(0).integers(0, _FOLDS, len(index))
    best = None
    for degree in _DEGREES:
        terms = polynomial(index, degree)
        if 2 * terms.shape[1] > 0.5 * len(index):
            break
        system = np.hstack([terms * across[:, :1], terms * across[:, 1:]])
        parts = [(system[fold == k], measured[fold == k]) for k in range(_FOLDS)]
        normal = [(a.T @ a, a.T @ b) for a, b in parts]
        error = []
        for k, (a, b) in enumerate(parts):
            left, right = (sum(pair[n] for m, pair in enumerate(normal) if m != k) for n in (0, 1))
            # A displacement along the normal is not seen across it: take the smallest solution.
            error.append(a @ (np.linalg.pinv(left, 1e-9, hermitian=True) @ right) - b)
        error = _rms(np.concatenate(error))
        if best is not None and error >= _BETTER * best[0]:
            break
        best = error, degree
    return best[1] if best else _DEGREES[0]


def _smoother(index, window):
    """Neighbours (n, k) of each point in ``window``, and their weights, which predict the point.

    A paraboloid is fitted to the neighbours, with a prior that it is level; the point itself is
    left out. Neighbours that do not exist have the weight zero.
    """
    number_of = {tuple(key): n for n, key in enumerate(index.tolist())}
    offsets = [(a, b) for a in range(-window[0], window[0] + 1)
               for b in range(-window[1], window[1] + 1) if (a, b) != (0, 0)]
    others = np.array([[number_of.get((i + a, j + b), -1) for a, b in offsets]
                       for i, j in index.tolist()])
    a, b = np.array(offsets, np.float64).T
    terms = np.stack([np.ones_like(a), a, b, a * a, a * b, b * b], axis=1)
    prior = _SHRINK * np.diag([0.1, 1, 1, 1, 1, 1])
    there = others >= 0
    kinds, which = np.unique(there, axis=0, return_inverse=True)
    weights = np.array([np.linalg.solve((terms * kind[:, None]).T @ terms + prior,
                                        (terms * kind[:, None]).T)[0] for kind in kinds])
    return np.maximum(others, 0), weights[which.ravel()]


def _rms(values):
    return float(np.sqrt(np.mean(np.sum(np.atleast_2d(values.T).T, axis=-1)**2)))
