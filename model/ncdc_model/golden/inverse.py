"""The map of a descriptor the other way: from distorted pixels to corrected ones."""

import cv2
import numpy as np

from ncdc_model.golden.network import coordinates

__all__ = ["inverse_map"]

_KNOTS = 48             # of the inverted map along either side


def inverse_map(descriptor):
    """Corrected pixel (u, v) of every distorted one, two float32 arrays.

    Outside of what the corrected frame sees, the nearest of its pixels.
    """
    geometry, scale = descriptor.geometry, 2.0**-descriptor.formats.coordinate.f_bits
    width, height = geometry.corrected
    u, v = np.meshgrid(np.linspace(0, width - 1, _KNOTS), np.linspace(0, height - 1, _KNOTS))
    u, v = np.rint(u).astype(np.int64), np.rint(v).astype(np.int64)
    x, y = (scale * value.ravel() for value in coordinates(descriptor, u, v))
    shape = (_KNOTS, _KNOTS, 2)
    found = _filled(np.column_stack([x, y]).reshape(shape),
                    np.column_stack([u.ravel(), v.ravel()]).reshape(shape), geometry.distorted)
    outside = np.isnan(found[..., 0])
    if outside.any():
        nearest = cv2.distanceTransformWithLabels(
            outside.astype(np.uint8), cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)[1]
        sources = np.zeros((nearest.max() + 1, 2))
        sources[nearest[~outside]] = found[~outside]
        found[outside] = sources[nearest[outside]]
    return tuple(np.ascontiguousarray(found[..., k], np.float32) for k in range(2))


def _filled(points, values, size):
    """Float32 (height, width, 2): ``values`` of a grid of ``points``, linear in the triangles
    between them; NaN outside. Both have the shape (rows, columns, 2).

    scipy's interpolation does the same, and takes 70 MB to import.
    """
    width, height = size
    found = np.full((height, width, 2), np.nan, np.float32)
    rows, columns = points.shape[:2]
    for row, column in np.ndindex(rows - 1, columns - 1):
        for corners in (((0, 0), (0, 1), (1, 0)), ((1, 1), (1, 0), (0, 1))):
            at = tuple(zip(*((row + down, column + right) for down, right in corners)))
            (first, *others), known = points[at], values[at]
            edges = np.array(others) - first
            low = np.maximum(np.ceil(points[at].min(axis=0)), 0).astype(int)
            high = np.minimum(np.floor(points[at].max(axis=0)), (width - 1, height - 1)).astype(int)
            if (low > high).any() or abs(np.linalg.det(edges)) < 1e-9:
                continue
            y, x = np.mgrid[low[1]:high[1] + 1, low[0]:high[0] + 1]
            weights = (np.stack([x, y], axis=-1) - first) @ np.linalg.inv(edges)
            inside = (weights >= -1e-9).all(axis=-1) & (weights.sum(axis=-1) <= 1 + 1e-9)
            value = known[0] + weights[inside] @ (known[1:] - known[0])
            found[low[1]:high[1] + 1, low[0]:high[0] + 1][inside] = value
    return found
