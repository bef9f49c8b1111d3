"""Source of each pixel of a view, in real numbers: the trained map after a matrix."""

import cv2
import numpy as np

from ncdc_model.evaluate import float_map

__all__ = ["plane_points", "view_map"]

_PASSES = 3             # to the raw row of a pixel; each divides its error by some 20
_EVERY = 4              # columns and rows of the view between which the raw row is interpolated
_NOWHERE = -16.0        # far enough outside for the border colour with any interpolation


def plane_points(matrix, u, v):
    """Points (u, v) of the trained picture of a view's pixels; not-a-number if not in front of it.

    ``matrix``: shape (..., 3, 3), as of :func:`ncdc_spec.view_matrix.view_matrix`.
    """
    x, y, depth = (matrix[..., k, 0] * u + matrix[..., k, 1] * v + matrix[..., k, 2]
                   for k in range(3))
    depth = np.where(depth > 0, depth, np.nan)
    return x / depth, y / depth


def view_map(descriptor, size, matrix):
    """Source pixels map_x, map_y, float32 (height, width), of a view, and ``blank``, bool.

    A pixel is blank if it is not in front of the camera, or its point of the trained picture is
    outside or has no source: the nearest pixel decides. As in hardware it is also blank if its
    source is more than a pixel outside of the raw frame. The map there is -16. The network is the
    descriptor's, in real numbers.

    Parameters
    ----------
    descriptor : Descriptor
    size : (int, int)
        Width and height of the view.
    matrix : ndarray, shape (3, 3) or (raw height, 3, 3)
        One for the frame, or one for each row of the raw frame. Between rows they are linear.
    """
    u, v = _grid(size)
    back_map = float_map(descriptor.exact_network, descriptor.geometry)
    if matrix.ndim == 3:
        matrix = _between(matrix, _raw_rows(back_map, size, matrix))
    return _filled(descriptor, back_map, *plane_points(matrix, u, v))


def _grid(size):
    width, height = size
    return np.meshgrid(np.arange(width, dtype=np.float64), np.arange(height, dtype=np.float64))


def _raw_rows(back_map, size, matrices):
    """Real raw row (height, width) that each pixel of a view is read from, with its own matrix."""
    u, v = (_EVERY * part for part in _grid([side // _EVERY + 2 for side in size]))
    row = np.full(u.shape, len(matrices) / 2)
    for _ in range(_PASSES):
        # The row depends on the matrix, which depends on the row.
        points = plane_points(_between(matrices, row), u, v)
        _, row = back_map(*(np.nan_to_num(part) for part in points))
    shrunk = np.array([[1 / _EVERY, 0, 0], [0, 1 / _EVERY, 0]])
    return cv2.warpAffine(row, shrunk, size, flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP)


def _between(matrices, row):
    """Matrices at real rows."""
    row = np.clip(row, 0, len(matrices) - 1)
    above = np.minimum(row.astype(np.intp), len(matrices) - 2)
    share = (row - above)[..., None, None]
    return (1 - share) * matrices[above] + share * matrices[above + 1]


def _filled(descriptor, back_map, u, v):
    """The result of :func:`view_map` for points of the trained picture."""
    width, height = descriptor.geometry.corrected
    with np.errstate(invalid="ignore"):
        used = (u > -.5) & (u < width - .5) & (v > -.5) & (v < height - .5)
    column, row = (np.rint(np.where(used, part, 0)).astype(np.intp) for part in (u, v))
    used &= descriptor.valid.mask(width)[row, column]
    x, y = back_map(np.where(used, u, 0), np.where(used, v, 0))
    used &= descriptor.geometry.inside_by(x, y) >= -1
    return *(np.where(used, part, _NOWHERE).astype(np.float32) for part in (x, y)), ~used
