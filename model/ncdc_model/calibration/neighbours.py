"""Compares position and size of each numbered point with its neighbours' prediction."""

from dataclasses import dataclass
from enum import Enum

import cv2
import numpy as np

from ncdc_model.calibration.median import known_median

__all__ = ["NeighbourCheck", "OutlierReason", "check_neighbours", "displaced", "fits_in",
           "neighbours", "parts"]

_WINDOW = 2            # columns and rows to either side that predict a point
# Regularisation of the change of a step, and of the change of that change, where few neighbours
# determine them, in weights of a point.
_RIDGE = np.array([1e-6, 0.02, 0.02, 0.2, 0.2, 0.2])
# Times the usual distance from the predicted position: a point farther off is an outlier. A lens
# fits better than a polynomial, and a photo of few points needs the tighter limit.
_SIGMAS, _SIGMAS_LENS = 9.0, 5.0
_MANY = 300            # points: a photo with more has many
_FLOOR = 0.60, 0.012   # pixels and parts of a step that a point may be off in any case
_SIZE_SIGMAS = 5.0     # times the usual difference of sizes: more is no dot
_KINK = 0.4, 4.0       # pixels, and times the usual: a line that bends more than nearby lines do
_RIM_FLOOR = 0.80      # pixels that a whole line at the edge may be off in any case
_RIM_WIDER = 1.6       # times the limit of inner positions: the lens bends most at the edge
_HALF_SIZE = 0.55       # logarithm of the ratio of a dot's size to those around it
_NEAR_BORDER = 2.2     # steps from the photo's border: an edge farther away is that of the page
_WITHIN = 0.5          # times the limit of inner positions, at such an edge
_RIM_SIZE = 1.7        # times the limit of inner sizes: the light falls off towards the edge
_CUT_FLOOR = 2.0       # pixels that a dot cut by the border may be off in any case
# Relative difference of sizes allowed in any case: smallest, largest, and times root of the area.
_SIZE = 0.15, 0.35, 3.5
_ROUNDS = 60
_MIN_NEIGHBOURS = 3             # within the window, that a point needs
# (points, degree) of the polynomial that removes most of the lens, for that many points or more.
_DEGREES = (150, 5), (60, 4), (24, 3), (0, 2)


class OutlierReason(Enum):
    """Why a numbered point is an outlier; the value is the text for people."""
    POSITION = "not where its neighbours predict it"
    SIZE = "of another size than its neighbours"
    RIM = "at the rim, and not where the lines further in predict it"
    LONELY = "with too few neighbours to check it"
    APART = "apart from the rest of the target"


@dataclass(frozen=True)
class NeighbourCheck:
    """Result of :func:`check_neighbours`.

    Parameters
    ----------
    keep : ndarray of bool, shape (n,)
        Which points agree with their neighbours.
    reasons : dict of int to OutlierReason
        Reason of each of the other points.
    sigma : float
        Usual distance of a good point from its prediction on one axis, in pixels.
    step : float
        Usual distance of neighbours in pixels.
    worst : float
        The largest distance of a good point from its prediction, in pixels.
    """
    keep: np.ndarray
    reasons: dict
    sigma: float
    step: float
    worst: float


def check_neighbours(index, xy, area=None, smooth=None, size=None):
    """Compare position and size of numbered points of one lattice with their neighbours'.

    A polynomial in column and row, or ``smooth``, removes most of the lens. The neighbours of a
    point, up to two columns and rows away, predict the rest by least squares of a parabola. A
    point farther off than usual is dropped, the worst of its surroundings first; then the others
    are predicted again. Dropped likewise are points whose area differs from their neighbours' by
    more than usual, lines at the edge that the inner lines do not predict, and points apart from
    the largest connected part.

    Parameters
    ----------
    index : ndarray of int, shape (n, 2)
        Column and row on a square lattice, each pair once.
    xy : ndarray, shape (n, 2)
    area : ndarray, shape (n,), optional
    smooth : ndarray, shape (n, 2), optional
        Positions that a smooth lens predicts: used where the points are too few for a polynomial.
    size : (int, int), optional
        Width and height of the photo. The limits at the edge of a page that ends within it, or at
        something that covers it, are tighter than at the photo's border, where the lens bends most.

    Returns
    -------
    NeighbourCheck
    """
    window = _Window(index)
    keep, reasons, step = np.ones(len(index), bool), {}, _step(window, xy)
    far, sigma = np.zeros(len(index)), 0.0
    for _ in range(_ROUNDS):
        rest = xy if smooth is None else xy - smooth
        if smooth is None or keep.sum() >= _DEGREES[0][0]:
            rest = rest - _smooth(window, rest, keep)
        predicted, gain, count = _predicted(window, rest, keep)
        far = np.linalg.norm(rest - predicted, axis=1)
        usual = np.sqrt(1 + gain)
        sigma = float(np.median((far / usual)[keep]) / 1.1774) if keep.any() else 0.0
        sigmas = _SIGMAS if smooth is None or len(index) > _MANY else _SIGMAS_LENS
        limit = np.maximum(max(_FLOOR[0], sigmas * sigma), _FLOOR[1] * step) * usual
        score = np.where(keep, far / limit, 0)
        bad = window.worst(score) & (score > 1)
        lonely = keep & (count < _MIN_NEIGHBOURS)
        if area is not None and not bad.any():
            score = np.where(keep, _size_score(window, area, keep), 0)
            sized = window.worst(score) & (score > 1)
            _note(reasons, sized, OutlierReason.SIZE)
            keep &= ~sized
            if sized.any():
                continue
        _note(reasons, bad, OutlierReason.POSITION)
        _note(reasons, lonely & ~bad, OutlierReason.LONELY)
        keep &= ~(bad | lonely)
        if not (bad | lonely).any():
            rim = keep & _rim_is_off(window, rest, area, keep,
                                     _rim_limits(xy, step, size, sigmas * sigma))
            _note(reasons, rim, OutlierReason.RIM)
            keep &= ~rim
            if not rim.any():
                break
    apart = keep & ~window.largest(keep)
    _note(reasons, apart, OutlierReason.APART)
    keep &= ~apart
    return NeighbourCheck(keep, reasons, sigma, float(np.median(step)) if len(step) else 0.0,
                float(far[keep].max(initial=0.0)))


def neighbours(index):
    """Numbers (n, 24) of the points up to two columns and rows away from each of ``index`` (n, 2);
    -1 where there is none."""
    return _Window(index).near


def displaced(index, xy):
    """Distance (n,) in pixels of each point from where its neighbours predict it, over the usual
    factor for as many neighbours."""
    window, keep = _Window(index), np.ones(len(index), bool)
    rest = xy - _smooth(window, xy, keep)
    predicted, gain, _ = _predicted(window, rest, keep)
    return np.linalg.norm(rest - predicted, axis=1) / np.sqrt(1 + gain)


def parts(index, xy):
    """Number (n,) of the part that each point of a lattice belongs to, -1 for none.

    Parts end where lines have a kink: there two targets, or one and its mirror image, join.
    """
    window = _Window(index)
    slot = {tuple(offset): k for k, offset in enumerate(window.offsets.tolist())}
    kink = np.zeros(len(index))
    for before, after in (((-1, 0), (1, 0)), ((0, -1), (0, 1))):
        first, second = window.near[:, slot[before]], window.near[:, slot[after]]
        both = (first >= 0) & (second >= 0)
        bend = np.where(both[:, None], xy[first] + xy[second] - 2 * xy, np.nan)
        # The lens bends lines too, but nearby ones by the same amount.
        near = np.where((window.near >= 0)[:, :, None], bend[window.near], np.nan)
        kink = np.fmax(kink, np.linalg.norm(bend - known_median(near), axis=1))
    limit = max(_KINK[0], _KINK[1] * float(np.nanmedian(kink)))
    smooth = kink <= limit
    there = np.zeros(window.grid.shape, bool)
    there[tuple(window.index[smooth].T)] = True
    _, labels = cv2.connectedComponents(there.view(np.uint8), connectivity=4)
    return np.where(smooth, labels[tuple(window.index.T)] - 1, -1)


def fits_in(index, xy, more_index, more_xy, sigma):
    """Which of further points, (k, 2) each, are where the good points ``index``, ``xy`` predict
    them; ``sigma`` as of :class:`NeighbourCheck`."""
    window = _Window(np.vstack([index, more_index]))
    positions = np.vstack([xy, more_xy])
    keep = np.arange(len(positions)) < len(index)
    rest = positions - _smooth(window, positions, keep)
    predicted, gain, _ = _predicted(window, rest, keep)
    off = np.linalg.norm(rest - predicted, axis=1)
    limit = max(_CUT_FLOOR, _SIGMAS * sigma) * np.sqrt(1 + gain)
    return (off <= limit)[len(index):]


def _note(reasons, which, reason):
    reasons.update(dict.fromkeys(np.flatnonzero(which).tolist(), reason))


class _Window:
    """Neighbours of the points ``index`` (n, 2): ``near`` (n, k), -1 where there is none, at
    the ``offsets`` (k, 2)."""

    def __init__(self, index):
        self.index = index - index.min(axis=0) + _WINDOW if len(index) else index
        shape = self.index.max(axis=0) + _WINDOW + 1 if len(index) else (5, 5)
        self.grid = np.full(tuple(shape), -1)
        self.grid[tuple(self.index.T)] = np.arange(len(index))
        side = np.arange(-_WINDOW, _WINDOW + 1)
        offsets = np.stack(np.meshgrid(side, side), axis=-1).reshape(-1, 2)
        self.offsets = offsets[(offsets != 0).any(axis=1)]
        i, j = (self.index[:, None] + self.offsets).transpose(2, 0, 1)
        self.near, self._terms = self.grid[i, j], {}

    def terms(self, degree):
        """Powers of column and row, scaled to -1..1, up to ``degree`` together: (n, terms)."""
        if degree not in self._terms:
            low, high = self.index.min(axis=0), self.index.max(axis=0)
            i, j = ((2 * self.index - low - high) / np.maximum(high - low, 1)).T
            self._terms[degree] = np.stack([i**a * j**b for a in range(degree + 1)
                                            for b in range(degree + 1 - a)], axis=1)
        return self._terms[degree]

    def worst(self, score):
        """Which points have the largest ``score`` (n,) of their window, themselves included."""
        around = np.where(self.near >= 0, score[self.near], 0).max(axis=1, initial=0)
        return (score > 0) & (score >= around)

    def largest(self, keep):
        """Which points belong to the largest part of ``keep``; a gap of one point joins."""
        there = np.zeros(self.grid.shape, bool)
        there[tuple(self.index[keep].T)] = True
        wide = cv2.dilate(there.view(np.uint8), np.ones((2, 2), np.uint8), anchor=(0, 0))
        count, labels = cv2.connectedComponents(wide, connectivity=4)
        if count < 3:       # the gaps have a label too
            return keep
        mine = labels[tuple(self.index.T)]
        sizes = np.bincount(mine[keep], minlength=count)
        return keep & (mine == sizes.argmax())


def _step(window, xy):
    """Distance (n,) of each point from its neighbours in a line, the usual one if it has none."""
    sides = np.abs(window.offsets).sum(axis=1) == 1
    near = window.near[:, sides]
    away = np.linalg.norm(xy[near] - xy[:, None], axis=2)
    away = np.where(near >= 0, away, np.nan)
    usual = np.nanmedian(away) if np.isfinite(away).any() else 1.0
    away = np.where(np.isfinite(away), away, usual)
    return np.median(away, axis=1)


def _smooth(window, xy, keep):
    """Positions (n, 2) by a polynomial in column and row, a robust fit to the points ``keep``."""
    degree = next(degree for count, degree in _DEGREES if keep.sum() >= count)
    terms, weight = window.terms(degree), keep.astype(float)
    for _ in range(4):
        root = np.sqrt(weight)[:, None]
        smooth = terms @ np.linalg.lstsq(terms * root, xy * root, rcond=1e-9)[0]
        rest = np.linalg.norm(xy - smooth, axis=1)
        usual = max(3 * np.median(rest[keep]), 0.1) if keep.any() else 1.0
        weight = keep / (1 + (rest / usual)**2)
    return smooth


def _rim_limits(xy, step, size, allowed):
    """Limits of points (n,) at the edge: pixels before the gain, pixels in any case, and factors of
    the usual limit of sizes. ``allowed``: pixels for inner points."""
    wider, sizes = np.full(len(xy), _RIM_WIDER), np.full(len(xy), _RIM_SIZE)
    if size is not None and len(xy) > _MANY:
        border = np.minimum(xy, np.array(size) - 1 - xy).min(axis=1)
        within = border > _NEAR_BORDER * step
        wider[within], sizes[within] = _WITHIN, 1.0
    return wider * allowed, np.maximum(_RIM_FLOOR, 2 * _FLOOR[1] * step), sizes


def _rim_is_off(window, rest, area, keep, limits):
    """Points of lines at the edge whose position or size the inner lines do not predict.

    Dots of a line that something cuts lengthwise agree with each other. ``limits``: see
    :func:`_rim_limits`.
    """
    wrong = np.zeros(len(rest), bool)
    there = (window.near >= 0) & keep[window.near]
    for axis in (0, 1):
        for sign in (1, -1):
            beyond = sign * window.offsets[:, axis]
            edge = keep & ~there[:, beyond > 0].any(axis=1)
            predicted, gain, count = _predicted(window, rest, keep, beyond < 0)
            off = np.linalg.norm(rest - predicted, axis=1)
            limit = np.maximum(limits[1], limits[0] * np.sqrt(1 + gain))
            known = edge & (count > _MIN_NEIGHBOURS + 1)
            wrong |= known & (off > limit)
            if area is not None:
                score = _size_score(window, area, keep, beyond < 0)
                wrong |= known & (score > limits[2])
    return wrong


def _predicted(window, values, keep, which=slice(None)):
    """Prediction (n, d) of ``values`` (n, d) at each point by its neighbours in ``keep``, its gain,
    and their number; ``which``: offsets of the window that are used."""
    near_ones = window.near[:, which]
    i, j = window.offsets[which].T.astype(float)
    terms = np.stack([np.ones_like(i), i, j, i * i, i * j, j * j], axis=1)
    near = (1 + i * i + j * j)**-0.5
    there = (near_ones >= 0) & keep[near_ones]
    weight = there * near
    product = (terms[:, :, None] * terms[:, None, :]).reshape(len(i), 36)
    matrix = (weight @ product).reshape(-1, 6, 6) + np.diag(_RIDGE)
    first = np.linalg.solve(matrix, np.broadcast_to(np.eye(6)[:, :1], (len(matrix), 6, 1)))[:, :, 0]
    share = (first @ terms.T) * weight
    return (np.einsum("nk,nkd->nd", share, values[near_ones]), (share**2).sum(axis=1),
            there.sum(axis=1))


def _size_score(window, area, keep, which=slice(None)):
    """Difference (n,) of each area from its neighbours' prediction, in units of the limit."""
    size = np.log(np.maximum(area, 1e-9))[:, None]
    predicted, gain, _ = _predicted(window, size - np.median(size), keep, which)
    off = np.abs(size - np.median(size) - predicted)[:, 0] / np.sqrt(1 + gain)
    usual = 1.4826 * float(np.median(off[keep])) if keep.any() else 0.0
    # The edge makes the area of a small dot uncertain.
    floor = np.clip(_SIZE[2] / np.sqrt(np.maximum(area, 1)), *_SIZE[:2])
    score = off / np.maximum(floor, _SIZE_SIGMAS * usual)
    # Near a hand few neighbours predict little, but no dot has half the size of those around it.
    there = (window.near >= 0) & keep[window.near]
    around = np.ma.median(np.ma.masked_array(size[window.near, 0], ~there), axis=1)
    return np.maximum(score, np.abs(size[:, 0] - around.filled(0)) / _HALF_SIZE * (
        there.sum(axis=1) >= _MIN_NEIGHBOURS))
