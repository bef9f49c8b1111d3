"""Masks of a map that is smooth, without its values at most pixels.

The frame is cut into square cells. Second differences of the map at their corners bound how far it
bends in between. Where that decides, the whole cell is set; elsewhere, as along the border of the
valid region, each pixel is evaluated as :func:`ncdc_model.golden.valid.masks_of` does.
"""

import numpy as np

from ncdc_model.golden.valid import Masks

__all__ = ["smooth_masks"]

_CELL = 16              # pixels
_SAFE = 2.0             # times the bend that second differences show
_ROUNDED = 3.0          # pixels: a hull of rounded points, and sources rounded to pixels
_CELLS = 256            # evaluated at a time: bounds the memory


def smooth_masks(map_function, geometry, covering=None):
    """The :class:`Masks` of ``masks_of``, for a map whose derivatives hardly change over 16 pixels:
    that of a smooth lens, or of a float network."""
    width, height = geometry.corrected
    corners = _Corners(map_function, width, height)
    inside, outside = corners.inside(geometry), corners.outside(geometry)
    # Whether they are the same as of each of its pixels.
    decided = outside | inside & corners.unfolded()
    masks = [_spread(inside, width, height), _spread(inside, width, height), None]
    if covering is not None:
        within, beyond = covering.hull_of(corners.x, corners.y, corners.bend + _ROUNDED)
        decided &= outside | within | beyond
        masks[2] = _spread(inside & within, width, height)
        masks[2] |= _spread(inside & beyond, width, height) & covering.near
    rows, columns = np.nonzero(~decided)
    for start in range(0, len(rows), _CELLS):
        part = slice(start, start + _CELLS)
        _evaluate(map_function, geometry, covering, masks, rows[part], columns[part])
    return Masks(*masks)


class _Corners:
    """Sources of the corners of all cells: ``x`` and ``y``, (rows + 1, columns + 1), and ``bend``
    (rows, columns), the pixels by which the map may leave the bilinear one in a cell."""

    def __init__(self, map_function, width, height):
        v, u = np.meshgrid(*(_CELL * np.arange(-(-size // _CELL) + 1.0)
                             for size in (height, width)), indexing="ij")
        self.x, self.y = map_function(u, v)
        changes = [_second(values, axis) for values in (self.x, self.y) for axis in (0, 1)]
        self.bend = _SAFE / 8 * _largest(np.maximum(changes[0] + changes[1],
                                                    changes[2] + changes[3]))
        # Of a step along each axis, over a cell: by the second difference and by the twist.
        self._change = _SAFE * (_largest(np.maximum.reduce(changes)) + np.maximum.reduce(
            [np.abs(np.diff(np.diff(values, axis=0), axis=1)) for values in (self.x, self.y)]))

    def inside(self, geometry):
        """Cells whose pixels all have a source in the image."""
        return _smallest(geometry.inside_by(self.x, self.y)) > self.bend + 1

    def outside(self, geometry):
        """Cells whose pixels all lie beyond the same side of the image, or see nothing."""
        core, offset = geometry.interpolation.core, geometry.interpolation.offset
        nothing = _largest(np.isfinite(self.x + self.y).astype(float)) == 0
        for values, size in zip((self.x, self.y), geometry.distorted):
            for side in (values - offset, size - core + 1 + offset - values):
                nothing |= _largest(side) < -self.bend - 1
        return nothing

    def unfolded(self):
        """Cells in which the map does not fold back."""
        right = [np.diff(values, axis=1) for values in (self.x, self.y)]
        down = [np.diff(values, axis=0) for values in (self.x, self.y)]
        area = np.minimum.reduce([
            right[0][i:len(right[0]) - 1 + i] * down[1][:, j:down[1].shape[1] - 1 + j]
            - right[1][i:len(right[0]) - 1 + i] * down[0][:, j:down[1].shape[1] - 1 + j]
            for i in (0, 1) for j in (0, 1)])
        longest = (np.maximum.reduce([np.abs(part[:-1]) + np.abs(part[1:]) for part in right])
                   + np.maximum.reduce([np.abs(part[:, :-1]) + np.abs(part[:, 1:])
                                        for part in down]))
        return area > self._change * (longest + 2 * self._change)


def _second(values, axis):
    """Magnitudes of the second differences along an axis, as many as ``values``."""
    if values.shape[axis] < 3:
        return np.full_like(values, np.nan)         # nothing is known: each pixel is evaluated
    change = np.abs(np.diff(values, 2, axis=axis))
    return np.pad(change, [(1, 1) if k == axis else (0, 0) for k in (0, 1)], "edge")


def _largest(corners):
    """The largest of the four corners of each cell; not-a-number if one is."""
    return np.maximum.reduce([corners[i:len(corners) - 1 + i, j:corners.shape[1] - 1 + j]
                              for i in (0, 1) for j in (0, 1)])


def _smallest(corners):
    return -_largest(-corners)


def _spread(cells, width, height):
    """Pixels (height, width) of ``cells``."""
    return np.repeat(np.repeat(cells, _CELL, axis=0), _CELL, axis=1)[:height, :width]


def _evaluate(map_function, geometry, covering, masks, rows, columns):
    """Set the pixels of some cells in ``masks``, one by one."""
    width, height = geometry.corrected
    side = np.arange(-1.0, _CELL + 1)
    v = _CELL * rows[:, None, None] + side[:, None] + 0 * side
    u = _CELL * columns[:, None, None] + 0 * side[:, None] + side
    x, y = map_function(u, v)
    for values in x, y:
        _end(values.swapaxes(1, 2), rows, height)
        _end(values, columns, width)
    # Without a source at a neighbour there is no derivative, and no fold is detected.
    folded = (np.gradient(x, axis=2) * np.gradient(y, axis=1)
              - np.gradient(x, axis=1) * np.gradient(y, axis=2)) <= 0
    own = np.zeros(u.shape, bool)
    own[:, 1:-1, 1:-1] = (u < width)[:, 1:-1, 1:-1] & (v < height)[:, 1:-1, 1:-1]
    x, y, at = x[own], y[own], (v[own].astype(np.intp), u[own].astype(np.intp))
    inside = geometry.window_inside(x, y)
    masks[0][at], masks[1][at] = inside, inside & ~folded[own]
    if covering is not None:
        masks[2][at] = covering(at, x, y, inside)


def _end(values, numbers, size):
    """Have ``values`` (n, ..., pixels) of the cells ``numbers`` (n,) go on straight beyond the
    frame of ``size`` pixels, so that differences at its edge are those within."""
    first, last = numbers == 0, numbers == (size - 1) // _CELL
    values[first, :, 0] = 2 * values[first, :, 1] - values[first, :, 2]
    end = (size - 1) % _CELL + 2
    values[last, :, end] = 2 * values[last, :, end - 1] - values[last, :, end - 2]
