"""Relief of a target that is not flat: what moves its points along the picture of its normal."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial.chebyshev import chebvander

__all__ = ["Relief", "find_relief", "line_scatter", "polynomial"]

_DEGREES = (3, 5, 7, 9, 11)   # of the polynomial that the lens may differ from the smooth one by
_BETTER = 0.97         # a higher degree must lessen the error to this part of it
_FOLDS = 5
_LEAST = 200           # points of a photo below which no relief is looked for
_DENSE = 200           # the same, for their scatter
_LONGER = 1.5          # times as much along the normal as across it: then there may be relief
_KNOWN = 0.6           # of the rms along the normal: neighbours must predict all but this part
_WINDOWS = ((2, 2), (3, 1), (1, 3), (4, 0), (0, 4))   # columns and rows to either side
_ROUNDS = 20           # of fitting lens and relief by turns
_SHRINK = 0.3          # weight of the prior that neighbours are alike


@dataclass(frozen=True)
class Relief:
    """How the shape of one photo's target shows in the picture.

    Parameters
    ----------
    along : ndarray, shape (n, 2)
        Unit vectors, in the picture, of a move along the target's normal.
    shift : ndarray, shape (n, 2)
        Pixels by which the relief moves the points, each told from its neighbours alone; zeros
        if there is no relief.
    degree : int
        Of the polynomial, in column and row, that describes what is left of the lens.
    found : bool
        Whether there may be relief.
    height : ndarray, shape (n,)
        Of the target at its points, in steps; the shift is that times the normal.
    """
    along: np.ndarray
    shift: np.ndarray
    degree: int
    found: bool
    height: np.ndarray

    @property
    def flat(self):
        """The same of a target that is taken as flat."""
        return replace(self, shift=np.zeros_like(self.shift), found=False,
                       height=np.zeros_like(self.height))


def find_relief(index, residual, normal):
    """What may be relief of a target, from one photo of it.

    A lens moves the points of a small area alike in any direction. A dent of the target moves them
    only along the picture of its normal. So the lens is a polynomial in column and row, of the
    degree that predicts held-out residuals *across* the normal best; what is left *along* the
    normal is relief, if it is much more than is left across and if the neighbours of a point
    predict it. A smooth bend of the target can not be told from a flaw of the lens: it is
    the lens's. A lens with a flaw that lies along the normal looks the same: one photo proves
    nothing (:mod:`ncdc_model.calibration.same_relief`).

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
    if len(index) < _LEAST:
        return nothing
    basis = np.linalg.qr(polynomial(index, degree))[0]

    def left(values):
        return values - basis @ (basis.T @ values)
    rest = left(residual)
    if _rms(rest * along) < _LONGER * _rms(rest * across):
        return nothing
    # A dent of one height moves the points by the normal's length: smooth the height, not pixels.
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
    """How far each point is from where its line says, along ``direction``, in pixels.

    Four neighbours in a row or column, two on either side, tell where the fifth is: no smooth lens
    shows in that. The differences are divided by 1.39, as the four are uncertain too: so their
    standard deviation is that of a single point. Shape (k,); empty if the photo has fewer than
    200 points, between which the lens would show.
    """
    place = {tuple(key): n for n, key in enumerate(np.asarray(index).tolist())}
    scatter = []
    if len(place) < _DENSE:
        return np.empty(0)
    steps = (1, 0), (0, 1)
    if len(np.unique(np.sum(index, axis=1) % 2)) == 1:         # staggered
        steps = (1, 1), (1, -1)
    for (i, j), n in place.items():
        for di, dj in steps:
            line = [place.get((i + k * di, j + k * dj)) for k in (-2, -1, 1, 2)]
            if None not in line:
                a, b, c, d = xy[line]
                scatter.append((xy[n] - (4 * (b + c) - a - d) / 6) @ direction[n])
    return np.array(scatter) / np.sqrt(1 + 34 / 36)


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
            # A move along the normal is not seen across it: of all solutions the least.
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
    place = {tuple(key): n for n, key in enumerate(index.tolist())}
    offsets = [(a, b) for a in range(-window[0], window[0] + 1)
               for b in range(-window[1], window[1] + 1) if (a, b) != (0, 0)]
    others = np.array([[place.get((i + a, j + b), -1) for a, b in offsets]
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
