"""Finds and numbers grids of dark circles, in lines or staggered, whole or in part."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.calibration.blobs import find_blobs, flat_field
from ncdc_model.calibration.lattice import number_lattice
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.errors import InputError

__all__ = ["Grid", "corners_touch", "find_circles", "find_grid"]

_ENOUGH = 12           # circles of a grid
_TOUCH = 0.75          # of the brightness between circles: less is the corner of two squares
_LINE = 0.5            # of a line's places must be filled, else it is a stray or two


@dataclass(frozen=True)
class Grid:
    """A numbered grid.

    Parameters
    ----------
    photo : PhotoPoints
        Indices from 0. Those of a staggered grid count half steps, so that every other place of
        each line is empty: column plus row is even everywhere, or odd everywhere.
    staggered : bool
    filled : float
        Part of the places of the surrounding rectangle that have a circle.
    """
    photo: PhotoPoints
    staggered: bool
    filled: float


def find_circles(image, columns, rows, staggered=False):
    """Centres of a grid of dark circles as PhotoPoints; a part of the grid will do.

    Parameters
    ----------
    image : ndarray of uint8
        (h, w) raw or grey, or (h, w, 3) RGB.
    columns, rows : int
        Of the grid as it lies in any quarter turn; of a staggered one the circles in a line and
        the lines, as OpenCV counts them.
    staggered : bool
        Whether every other line is moved by half a step.

    Raises
    ------
    InputError
        If no such grid is found.
    """
    size = (2 * columns, rows) if staggered else (columns, rows)
    grid = find_grid(image, staggered, size)
    if grid is None:
        raise InputError(f"no {'staggered ' * staggered}grid of {columns}x{rows} circles was found")
    return grid.photo


def find_grid(image, staggered=None, size=None):
    """The grid of dark circles that the picture shows, or None.

    The lattice of the circles is walked without knowing whether it is a square one, or a
    staggered one, which is a lattice too: one with oblique steps. Of all ways to read it that one
    is taken whose circles fill their surrounding rectangle best.

    Parameters
    ----------
    image : ndarray of uint8
    staggered : bool, optional
        Which kind is looked for; default both.
    size : (int, int), optional
        Largest extent of the indices, in this order or the other: circles beyond it are strays.
    """
    blobs = find_blobs(image)
    if len(blobs.xy) < _ENOUGH:
        return None
    where, walked, dropped = number_lattice(blobs.xy, np.median(blobs.xy, axis=0))
    if len(where) < _ENOUGH:
        return None
    xy, best = blobs.xy[where], None
    for kind in (False, True) if staggered is None else (staggered,):
        for turn in _readings(kind):
            index = walked @ turn
            for extent in {size, size and size[::-1]}:
                keep = _inside(index, kind, extent)
                if keep.sum() < _ENOUGH:
                    continue
                span = np.ptp(index[keep], axis=0) + 1
                places = np.prod(span) / (2 if kind else 1)
                score = keep.sum() * keep.sum() / places, _upright(index[keep], xy[keep])
                if best is None or score > best[0]:
                    best = score, kind, index, keep, keep.sum() / places
    if best is None:
        return None
    _, kind, index, keep, filled = best
    rejected = dict(blobs.rejected)
    for reason, count in (("out of line with its neighbours", dropped),
                          ("not on the grid", len(blobs.xy) - dropped - int(keep.sum())),
                          ("cut by the border", len(blobs.cut))):
        if count:
            rejected[reason] = count
    index = index[keep] - index[keep].min(axis=0)
    return Grid(PhotoPoints(index=index, xy=xy[keep], area=blobs.area[where][keep],
                            rejected=rejected), kind, float(filled))


def corners_touch(image, grid):
    """Whether the spots of a staggered :class:`Grid` are the black squares of a chessboard.

    Black squares touch at their corners: half-way between two it is half as bright as on white,
    between two circles as bright.
    """
    flat = cv2.GaussianBlur(flat_field(image), (0, 0), 1)
    place = {tuple(key): point for key, point in zip(grid.photo.index.tolist(), grid.photo.xy)}
    spots, between = [], []
    for (i, j), point in place.items():
        for other in ((i + 1, j + 1), (i - 1, j + 1)):
            if other in place:
                spots.append(point)
                between.append((point + place[other]) / 2)
    if not between:
        return False
    dark, half = (np.median(cv2.remap(flat, np.array(points, np.float32)[None], None,
                                      cv2.INTER_LINEAR)) for points in (spots, between))
    (left, top), (right, bottom) = (np.round(end(grid.photo.xy, axis=0)).astype(int)
                                    for end in (np.min, np.max))
    bright = np.percentile(flat[top:bottom + 1, left:right + 1], 90)
    return bool(half - dark < _TOUCH * (bright - dark))


def _readings(staggered):
    """Matrices that turn the walk's steps into columns and rows, none of them mirrored."""
    ends = ([(1, 1), (1, -1), (-1, 1), (-1, -1), (2, 0), (-2, 0), (0, 2), (0, -2)] if staggered
            else [(1, 0), (-1, 0), (0, 1), (0, -1)])
    area = 2 if staggered else 1
    for first in ends:
        for second in ends:
            if first[0] * second[1] - first[1] * second[0] == area:
                yield np.array([first, second])


def _inside(index, staggered, extent):
    """Which points belong to lines that are filled well enough, or to the fullest ``extent``."""
    keep = np.ones(len(index), bool)
    while True:
        before = keep.sum()
        for axis in (0, 1):
            if not keep.any():
                return keep
            lines, counts = np.unique(index[keep, axis], return_counts=True)
            usual = np.median(counts)
            for line, count in zip(lines, counts):
                # Only lines at the rim: one within may have lost circles.
                if line in (lines[0], lines[-1]) and count < _LINE * usual:
                    keep &= index[:, axis] != line
        if keep.sum() == before:
            break
    if extent is not None:
        for axis in (0, 1):
            low, high = index[keep, axis].min(), index[keep, axis].max()
            if high - low + 1 > extent[axis]:
                start = max(range(low, high - extent[axis] + 2), key=lambda s: np.sum(
                    keep & (index[:, axis] >= s) & (index[:, axis] < s + extent[axis])))
                keep &= (index[:, axis] >= start) & (index[:, axis] < start + extent[axis])
    return keep


def _upright(index, xy):
    """How far columns run to the right and rows downwards: at most 2, rounded to compare."""
    terms = np.column_stack([index, np.ones(len(index))])
    steps = np.linalg.lstsq(terms, xy, rcond=None)[0][:2]
    steps = steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)
    return round(float(steps[0, 0] + steps[1, 1]), 6)
