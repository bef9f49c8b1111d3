"""Finds the inner corners of chessboards and their lattices."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.calibration.board_edges import are_squares, on_edges, readings
from ncdc_model.calibration.lattice import find_lattices
from ncdc_model.calibration.sampling import bilinear
from ncdc_model.calibration.subpixel import refine

__all__ = ["CornerLattice", "check_squares", "cornerlike", "find_corner_lattices"]

_SIDE = 1300           # pixels of the longer side of the searched copy
_SCALES = 1.5, 2.5, 4.5, 8.0    # pixels: a sharp photo, and blurred ones
_RING = 2.2            # scales: radius of the ring around a corner
_TURN = 32             # samples on it
_LIKE = 0.75           # smallest correlation of the ring with itself turned by half a turn
_MIDDLE = 0.22, 0.78   # a corner's brightness, between the ring's darkest and brightest
_CONTRAST = 0.12       # of the usual corner's contrast: fainter ones are texture
_MAX_CANDIDATES = 4000
_MIN_CORNERS = 9       # of a lattice
_ALIKE = 0.8           # of a board's squares and corners must look like a chessboard's
_INSET = 0.22          # of a square, from its sides: where its brightness is sampled


@dataclass(frozen=True)
class CornerLattice:
    """Corners of one board: ``index`` (n, 2), ``xy`` (n, 2) in pixels, and ``scale``, the blur in
    pixels at which they were found."""
    index: np.ndarray
    xy: np.ndarray
    scale: float


def find_corner_lattices(grey, most=2, enough=0):
    """Boards, at most ``most``, that the grey picture shows, the one with most corners first.

    A corner is a saddle of brightness whose surroundings look the same after half a turn, dark and
    bright twice each, and whose own brightness lies between. Corners are searched for at several
    scales and numbered like dots, until a board has as many as are ``enough``. Their squares must
    alternate between dark and bright. Saddles between round dots do not qualify: they are as
    bright as the page.

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
        if best and len(best[0].xy) == enough:
            break
    boards = []
    for board in best:
        xy = (board.xy + 0.5) / shrink - 0.5
        xy = refine(grey, board.index, xy, board.scale / shrink)
        boards.append(CornerLattice(board.index, xy, board.scale / shrink))
    return boards


def _at_scale(grey, scale, most):
    smooth = cv2.GaussianBlur(grey, (0, 0), scale)
    positions = _saddles(smooth, scale)
    if len(positions) < _MIN_CORNERS:
        return []
    boards = []
    for lattice in find_lattices(positions, np.median(positions, axis=0), most + 1):
        index, xy = lattice.index, positions[lattice.where]
        for reading in readings():
            keep = check_squares(smooth, index @ reading, xy)
            if keep.sum() >= max(_MIN_CORNERS, _ALIKE * len(index)) and are_squares(
                    smooth, (index @ reading)[keep], xy[keep]):
                index = index @ reading
                keep[keep] = on_edges(smooth, index[keep], xy[keep])
                break
        else:
            continue
        if keep.sum() >= max(_MIN_CORNERS, _ALIKE * len(index)):
            keep = trimmed(index, keep)
        else:
            keep &= False
        if keep.sum() >= _MIN_CORNERS:
            boards.append(CornerLattice(index[keep] - index[keep].min(axis=0), xy[keep], scale))
    return sorted(boards, key=lambda board: -len(board.xy))[:most]


def _saddles(smooth, scale):
    """Positions (n, 2) of the corners at one scale."""
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
    # Move to the saddle's sub-pixel position, where the gradient vanishes.
    a, b, c = xx[rows, columns], xy[rows, columns], yy[rows, columns]
    g, h = dx[rows, columns], dy[rows, columns]
    det = a * c - b * b
    move = np.stack([(-g * c + h * b) / det, (g * b - h * a) / det], axis=1)
    near = np.abs(move).max(axis=1) < max(1.0, scale)
    order = np.argsort(-strength[rows, columns][near])[:_MAX_CANDIDATES]
    positions = (np.stack([columns, rows], axis=1) + move)[near][order]
    return positions[cornerlike(smooth, positions, _RING * scale)]


def cornerlike(smooth, positions, radius):
    """Which ``positions`` (n, 2) have a ring of two dark and two bright parts around them.

    ``radius``: of the ring in pixels, one or (n,).
    """
    if not len(positions):
        return np.zeros(0, bool)
    turns = 2 * np.pi * np.arange(_TURN) / _TURN
    ring = np.stack([np.cos(turns), np.sin(turns)], axis=1)
    at = positions[:, None] + np.reshape(radius, (-1, 1, 1)) * ring
    values = bilinear(smooth, at)
    middle = bilinear(smooth, positions)
    low, high = np.percentile(values, (10, 90), axis=1)
    level = (middle - low) / np.maximum(high - low, 1e-6)
    off = values - values.mean(axis=1, keepdims=True)
    power = np.maximum((off * off).sum(axis=1), 1e-9)
    symmetry = (off * np.roll(off, _TURN // 2, axis=1)).sum(axis=1) / power
    bright = values > ((low + high) / 2)[:, None]
    changes = (bright != np.roll(bright, 1, axis=1)).sum(axis=1)
    good = ((changes == 4) & (symmetry > _LIKE) & (level > _MIDDLE[0]) & (level < _MIDDLE[1])
            & (high > low + 1))
    if good.any():
        # Contrast relative to the brightness, so that dark photos and corners count as much.
        contrast = (high - low) / np.maximum(high + low, 8)
        good &= contrast > _CONTRAST * np.percentile(contrast[good], 90)
    return good


def check_squares(picture, index, xy):
    """Which corners belong to squares that alternate between dark and bright.

    Every square of four corners is sampled in its middle and towards its four sides. At least four
    of the five samples must lie on one side of the brightness half-way to the adjacent squares. A
    lattice that skips lines of corners fails, and so does one over anything else. A corner without
    a good square is dropped.

    Parameters
    ----------
    picture : ndarray
        Grey.
    index, xy : ndarray, shape (n, 2)

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    position = np.full((*(np.ptp(index, axis=0) + 2), 2), np.nan)
    origin = index.min(axis=0)
    position[tuple((index - origin).T)] = xy
    corners = position[:-1, :-1], position[1:, :-1], position[1:, 1:], position[:-1, 1:]
    whole = np.isfinite(sum(corners)).all(axis=2)
    s, r = 0.5, _INSET
    spots = []
    for a, b in ((s, s), (r, s), (1 - r, s), (s, r), (s, 1 - r)):
        weights = (1 - a) * (1 - b), a * (1 - b), a * b, (1 - a) * b
        spots.append(sum(w * np.nan_to_num(corner) for w, corner in zip(weights, corners)))
    values = bilinear(picture, np.stack(spots, axis=2))
    middle = np.where(whole, np.median(values, axis=2), np.nan)
    i, j = np.indices(whole.shape)
    sign = np.where((i + j) % 2, 1, -1)
    # Half-way between each square and the adjacent ones, from the two means.
    level = _level(middle, sign)
    side = (values - level[:, :, None]) * sign[:, :, None]
    votes = np.sign(side[..., 0][whole & np.isfinite(level)])
    if not len(votes):
        return np.zeros(len(index), bool)
    side = side * (1 if votes.sum() >= 0 else -1)
    # Markers of a ChArUco board, pen or glare may hide one of the five.
    good = whole & ((side > 0).sum(axis=2) >= 4) & (side[..., 0] > -np.inf)
    touched = np.zeros(position.shape[:2], bool)
    bad = np.zeros(position.shape[:2], int)
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
    """``keep`` without lines at the edge of which most positions are empty."""
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
