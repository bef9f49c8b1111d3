"""Finds where the squares of chessboards touch, and the lattices of these corners."""

from dataclasses import dataclass

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

from ncdc_model.calibration.board_edges import are_squares, on_edges, readings
from ncdc_model.calibration.lattice import find_lattices
from ncdc_model.calibration.subpixel import refine

__all__ = ["CornerLattice", "check_squares", "find_corner_lattices"]

_SIDE = 1300           # pixels of the longer side at which corners are looked for
_SCALES = 1.5, 2.5, 4.5, 8.0    # pixels: a sharp photo, and blurred ones
_RING = 2.2            # scales: radius of the ring around a corner
_TURN = 32             # samples on it
_LIKE = 0.75           # least correlation of the ring with itself turned by half a turn
_MIDDLE = 0.22, 0.78   # a corner's brightness, between the ring's darkest and brightest
_CONTRAST = 0.12       # of the usual corner's contrast: fainter ones are texture
_MOST = 4000           # candidates
_LEAST = 9             # corners of a lattice
_ALIKE = 0.8           # of a board's squares and corners must be as a chessboard's
_INSET = 0.22          # of a square, from its rim: where its brightness is looked at


@dataclass(frozen=True)
class CornerLattice:
    """Corners of one board: ``index`` (n, 2), ``xy`` (n, 2) in pixels, and ``scale``, the blur in
    pixels at which they were found."""
    index: np.ndarray
    xy: np.ndarray
    scale: float


def find_corner_lattices(grey, most=2):
    """The boards, at most ``most``, that the grey picture shows, the one of most corners first.

    A corner is a saddle of brightness whose surroundings look the same after half a turn, dark and
    bright twice each, and whose own brightness lies between. Corners are looked for at several
    scales, the lattices are walked as those of dots, and their squares must be dark and bright by
    turns. Saddles between round dots are not: there it is as bright as on the page.

    Returns
    -------
    list of :class:`CornerLattice`
    """
    shrink = min(1.0, _SIDE / max(grey.shape))
    small = grey if shrink == 1 else cv2.resize(grey, None, fx=shrink, fy=shrink,
                                                interpolation=cv2.INTER_AREA)
    small, best = small.astype(np.float32), []
    for scale in _SCALES:
        found = _at_scale(small, scale, most)
        if sum(len(board.xy) for board in found) > 1.05 * sum(len(board.xy) for board in best):
            best = found
    boards = []
    for board in best:
        xy = (board.xy + 0.5) / shrink - 0.5
        xy = refine(grey, board.index, xy, board.scale / shrink)
        boards.append(CornerLattice(board.index, xy, board.scale / shrink))
    return boards


def _at_scale(grey, scale, most):
    smooth = cv2.GaussianBlur(grey, (0, 0), scale)
    places = _saddles(smooth, scale)
    if len(places) < _LEAST:
        return []
    boards = []
    for lattice in find_lattices(places, np.median(places, axis=0), most + 1):
        index, xy = lattice.index, places[lattice.where]
        for reading in readings():
            keep = check_squares(smooth, index @ reading, xy)
            if keep.sum() >= max(_LEAST, _ALIKE * len(index)) and are_squares(
                    smooth, (index @ reading)[keep], xy[keep]):
                index = index @ reading
                keep[keep] = on_edges(smooth, index[keep], xy[keep])
                break
        else:
            continue
        if keep.sum() >= max(_LEAST, _ALIKE * len(index)):
            keep = trimmed(index, keep)
        else:
            keep &= False
        if keep.sum() >= _LEAST:
            boards.append(CornerLattice(index[keep] - index[keep].min(axis=0), xy[keep], scale))
    return sorted(boards, key=lambda board: -len(board.xy))[:most]


def _saddles(smooth, scale):
    """Places (n, 2) of the corners at one scale."""
    dx, dy = (cv2.Sobel(smooth, cv2.CV_32F, *order, ksize=3, scale=1 / 8)
              for order in ((1, 0), (0, 1)))
    xx, xy = (cv2.Sobel(dx, cv2.CV_32F, *order, ksize=3, scale=1 / 8)
              for order in ((1, 0), (0, 1)))
    yy = cv2.Sobel(dy, cv2.CV_32F, 0, 1, ksize=3, scale=1 / 8)
    strength = xy * xy - xx * yy
    side = 2 * int(np.ceil(1.5 * scale)) + 1
    peak = (strength == cv2.dilate(strength, np.ones((side, side), np.uint8))) & (strength > 0)
    margin = int(np.ceil(1.2 * _RING * scale)) + 1
    peak[:margin] = peak[-margin:] = peak[:, :margin] = peak[:, -margin:] = False
    rows, columns = np.nonzero(peak)
    # A saddle's own place: where the gradient vanishes.
    a, b, c = xx[rows, columns], xy[rows, columns], yy[rows, columns]
    g, h = dx[rows, columns], dy[rows, columns]
    det = a * c - b * b
    move = np.stack([(-g * c + h * b) / det, (g * b - h * a) / det], axis=1)
    near = np.abs(move).max(axis=1) < max(1.0, scale)
    order = np.argsort(-strength[rows, columns][near])[:_MOST]
    places = (np.stack([columns, rows], axis=1) + move)[near][order]
    return places[_cornerlike(smooth, places, _RING * scale)]


def _cornerlike(smooth, places, radius):
    """Which ``places`` have a ring of two dark and two bright parts around them."""
    if not len(places):
        return np.zeros(0, bool)
    turns = 2 * np.pi * np.arange(_TURN) / _TURN
    ring = radius * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    at = places[:, None] + ring
    values = _sample(smooth, at)
    middle = _sample(smooth, places)
    low, high = np.percentile(values, (10, 90), axis=1)
    level = (middle - low) / np.maximum(high - low, 1e-6)
    off = values - values.mean(axis=1, keepdims=True)
    power = np.maximum((off * off).sum(axis=1), 1e-9)
    alike = (off * np.roll(off, _TURN // 2, axis=1)).sum(axis=1) / power
    bright = values > ((low + high) / 2)[:, None]
    changes = (bright != np.roll(bright, 1, axis=1)).sum(axis=1)
    good = ((changes == 4) & (alike > _LIKE) & (level > _MIDDLE[0]) & (level < _MIDDLE[1])
            & (high > low + 1))
    if good.any():
        # Contrast relative to the brightness, so that a dark photo or corner counts as much.
        contrast = (high - low) / np.maximum(high + low, 8)
        good &= contrast > _CONTRAST * np.percentile(contrast[good], 90)
    return good


def _sample(picture, at):
    return map_coordinates(picture, [at[..., 1], at[..., 0]], order=1, mode="nearest")


def check_squares(picture, index, xy):
    """Which corners belong to squares that are dark and bright by turns, each all over.

    Every square of four corners is looked at in its middle and towards its four sides: all five
    places must lie on one side of the brightness half-way to the squares beside it. So a lattice
    that skips lines of corners fails, and one over anything else. A corner with no square of its
    own is not kept.

    Parameters
    ----------
    picture : ndarray
        Grey.
    index, xy : ndarray, shape (n, 2)

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    place = np.full((*(np.ptp(index, axis=0) + 2), 2), np.nan)
    origin = index.min(axis=0)
    place[tuple((index - origin).T)] = xy
    corners = place[:-1, :-1], place[1:, :-1], place[1:, 1:], place[:-1, 1:]
    whole = np.isfinite(sum(corners)).all(axis=2)
    s, r = 0.5, _INSET
    spots = []
    for a, b in ((s, s), (r, s), (1 - r, s), (s, r), (s, 1 - r)):
        weights = (1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b
        spots.append(sum(w * np.nan_to_num(corner) for w, corner in zip(weights, corners)))
    values = _sample(picture, np.stack(spots, axis=2))
    middle = np.where(whole, np.median(values, axis=2), np.nan)
    i, j = np.indices(whole.shape)
    sign = np.where((i + j) % 2, 1, -1)
    # Half-way between each square and those beside it, from the two means.
    level = _level(middle, sign)
    side = (values - level[:, :, None]) * sign[:, :, None]
    votes = np.sign(side[..., 0][whole & np.isfinite(level)])
    if not len(votes):
        return np.zeros(len(index), bool)
    side = side * (1 if votes.sum() >= 0 else -1)
    # Markers of a ChArUco board, pen or glare may hide one of the five.
    good = whole & ((side > 0).sum(axis=2) >= 4) & (side[..., 0] > -np.inf)
    touched = np.zeros(place.shape[:2], bool)
    bad = np.zeros(place.shape[:2], int)
    for di in (0, 1):
        for dj in (0, 1):
            touched[di:di + good.shape[0], dj:dj + good.shape[1]] |= good
            bad[di:di + good.shape[0], dj:dj + good.shape[1]] += whole & ~good
    at = tuple((index - origin).T)
    return touched[at] & (bad[at] < 2)


def _level(middle, sign):
    """Brightness half-way between dark and bright squares around each square."""
    means = []
    for which in (1, -1):
        there = np.isfinite(middle) & (sign == which)
        value = np.where(there, middle, 0).astype(np.float32)
        total, count = (cv2.blur(part.astype(np.float32), (5, 5), borderType=cv2.BORDER_CONSTANT)
                        for part in (value, there))
        means.append(np.where(count > 1e-6, total / np.maximum(count, 1e-6), np.nan))
    return sum(means) / 2


def trimmed(index, keep):
    """``keep`` without lines at the rim of which most places are empty."""
    keep = keep.copy()
    while keep.any():
        before = keep.sum()
        for axis in (0, 1):
            lines, counts = np.unique(index[keep, axis], return_counts=True)
            usual = np.median(counts) if len(counts) else 0
            for line, count in zip(lines, counts):
                if line in (lines[0], lines[-1]) and count < max(2, 0.34 * usual):
                    keep &= index[:, axis] != line
            if not keep.any():
                break
        if keep.sum() == before:
            break
    return keep
