"""Finds and numbers grids of dark circles, in lines or staggered, whole or in part."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from ncdc_model.calibration.blobs import flat_field
from ncdc_model.calibration.dots import find_spots
from ncdc_model.calibration.outliers import location_text, without_outliers
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.calibration.sampling import sample
from ncdc_spec.errors import InputError

__all__ = ["Grid", "corners_touch", "find_circles", "grid_of_size", "read_grid"]

_ENOUGH = 12           # circles of a grid
_TOUCH = 0.75          # of the brightness between circles: corners of two squares have less
_LINE = 0.5            # of a line's positions must have a circle, else its circles are strays
_STRAY = "not on the grid"


@dataclass(frozen=True)
class Grid:
    """A numbered grid.

    Parameters
    ----------
    photo : PhotoPoints
        Indices from 0. A staggered grid counts half steps, so that every other position of each
        line is empty: column plus row is even everywhere, or odd everywhere.
    staggered : bool
    filled : float
        Part of the positions of the surrounding rectangle that have a circle.
    """
    photo: PhotoPoints
    staggered: bool
    filled: float


def find_circles(image, columns, rows, staggered=False):
    """Centres of a grid of dark circles as PhotoPoints; a part of the grid is sufficient.

    Parameters
    ----------
    image : ndarray of uint8
        (h, w) raw or grey, or (h, w, 3) RGB.
    columns, rows : int
        Size of the grid in any quarter turn. Of a staggered grid: circles in a line, and lines, as
        OpenCV counts them.
    staggered : bool
        Whether every other line is shifted by half a step.

    Raises
    ------
    InputError
        If no such grid is found, or a larger one, or one of squares.
    """
    return grid_of_size(find_spots(image), columns, rows, staggered)


def grid_of_size(spots, columns, rows, staggered=False):
    """:func:`find_circles` from a photo's :class:`ncdc_model.calibration.dots.Spots`."""
    spots.check_round()
    size = (2 * columns, rows) if staggered else (columns, rows)
    grids = [grid for grid in (read_grid(spots.size, lattice, staggered)
                               for lattice in spots.lattices) if grid is not None]
    fitting = [grid for grid in grids if _fits(grid, size)]
    larger = [grid for grid in grids if not _fits(grid, size)]
    if larger and (not fitting or len(larger[0].photo.index) > 2 * len(fitting[0].photo.index)):
        across, down = np.ptp(larger[0].photo.index, axis=0) + 1
        raise InputError(f"it shows {len(larger[0].photo.index)} circles or dots, {across} columns "
                         f"by {down} rows{' of half steps' * staggered}, not a grid of "
                         f"{columns}x{rows}")
    if not fitting:
        raise InputError(spots.doubt or f"no {'staggered ' * staggered}grid of {columns}x{rows} "
                                        f"circles was found")
    best = max(fitting, key=lambda grid: (len(grid.photo.index) == columns * rows,
                                          len(grid.photo.index)))
    return replace(best.photo, remarks=best.photo.remarks + tuple(
        f"another grid, {len(grid.photo.index)} circles {location_text(grid.photo)}, is not used"
        for grid in grids if grid is not best))


def _fits(grid, size):
    across, down = np.ptp(grid.photo.index, axis=0) + 1
    return (across <= size[0] and down <= size[1]) or (across <= size[1] and down <= size[0])


def read_grid(size, lattice, staggered=None):
    """The ``lattice``, PhotoPoints of a photo of ``size``, as a :class:`Grid`, or None.

    The lattice may be square or staggered: a staggered grid is a lattice with oblique steps. The
    result is the reading whose circles fill their surrounding rectangle best.
    """
    best = None
    for kind in (False, True) if staggered is None else (staggered,):
        for turn in _readings(kind):
            index = lattice.index @ turn
            keep = _inside(index)
            if keep.sum() < _ENOUGH:
                continue
            span = np.ptp(index[keep], axis=0) + 1
            positions = np.prod(span) / (2 if kind else 1)
            score = keep.sum() * keep.sum() / positions, _upright(index[keep], lattice.xy[keep])
            if best is None or score > best[0]:
                best = score, kind, index, keep
    if best is None:
        return None
    _, kind, index, keep = best
    rejected = dict(lattice.rejected)
    dropped = lattice.dropped
    if not keep.all():
        rejected[_STRAY] = int((~keep).sum())
        dropped += tuple((float(x), float(y), _STRAY) for x, y in lattice.xy[~keep])
    index = index[keep] - index[keep].min(axis=0)
    photo = replace(lattice, index=index, xy=lattice.xy[keep], area=lattice.area[keep],
                    cut=lattice.cut[keep], rejected=rejected, dropped=dropped)
    if not kind and len(photo.index) >= 9:
        photo = without_outliers(size, photo)
    if len(photo.index) < _ENOUGH:
        return None
    positions = np.prod(np.ptp(photo.index, axis=0) + 1) / (2 if kind else 1)
    return Grid(photo, kind, float(len(photo.index) / positions))


def corners_touch(image, grid):
    """Whether the spots of a staggered :class:`Grid` are the black squares of a chessboard.

    Black squares touch at their corners: half-way between two the brightness is half that of
    white. Between two circles it is that of white.
    """
    flat = cv2.GaussianBlur(flat_field(image), (0, 0), 1)
    position = {tuple(key): point for key, point in zip(grid.photo.index.tolist(), grid.photo.xy)}
    spots, between = [], []
    for (i, j), point in position.items():
        for other in ((i + 1, j + 1), (i - 1, j + 1)):
            if other in position:
                spots.append(point)
                between.append((point + position[other]) / 2)
    if not between:
        return False
    dark, half = (np.median(sample(flat, points)) for points in (spots, between))
    (left, top), (right, bottom) = (np.round(end(grid.photo.xy, axis=0)).astype(int)
                                    for end in (np.min, np.max))
    bright = np.percentile(flat[top:bottom + 1, left:right + 1], 90)
    return bool(half - dark < _TOUCH * (bright - dark))


def _readings(staggered):
    """Matrices from the lattice's steps to columns and rows, without reflections."""
    ends = ([(1, 1), (1, -1), (-1, 1), (-1, -1), (2, 0), (-2, 0), (0, 2), (0, -2)] if staggered
            else [(1, 0), (-1, 0), (0, 1), (0, -1)])
    area = 2 if staggered else 1
    for first in ends:
        for second in ends:
            if first[0] * second[1] - first[1] * second[0] == area:
                yield np.array([first, second])


def _inside(index):
    """Which points belong to lines that are filled well enough."""
    keep = np.ones(len(index), bool)
    while True:
        before = keep.sum()
        for axis in (0, 1):
            if not keep.any():
                return keep
            lines, counts = np.unique(index[keep, axis], return_counts=True)
            usual = np.median(counts)
            for line, count in zip(lines, counts):
                # Only lines at the edge: an inner one may have lost circles.
                if line in (lines[0], lines[-1]) and count < _LINE * usual:
                    keep &= index[:, axis] != line
        if keep.sum() == before:
            return keep


def _upright(index, xy):
    """Degree, at most 2, to which columns run right and rows down; rounded for comparison."""
    terms = np.column_stack([index, np.ones(len(index))])
    steps = np.linalg.lstsq(terms, xy, rcond=None)[0][:2]
    steps = steps / np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1e-12)
    return round(float(steps[0, 0] + steps[1, 1]), 6)
