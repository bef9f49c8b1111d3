"""Light on the emulated sensor: a photo, or the built-in scene in motion."""

import cv2
import numpy as np

from ncdc_model.example import scene_at
from ncdc_model.golden.corrector import check_raw
from ncdc_model.golden.network import coordinates
from ncdc_model.images import is_raw, mosaic

__all__ = ["POSITIONS", "MovingScene", "Photo"]

POSITIONS = 16          # of the scene in motion, before it repeats
_SWING = 0.05           # of the picture's width that it moves to either side
_MARGIN = 0.25          # of the width that is painted around the corrected frame
_BAND = 32              # rows that are painted at a time: a pixel takes 100 bytes meanwhile
_KNOTS = 48             # of the inverted map along the longer side


class Photo:
    """The same raw frame again and again.

    Parameters
    ----------
    image : ndarray
        Raw frame, or an RGB picture, which is mosaiced; of the distorted size.
    geometry : Geometry

    Raises
    ------
    InputError
        If it is of another size.
    """
    def __init__(self, image, geometry):
        self._raw = image if is_raw(image) else mosaic(image, geometry.bayer)
        check_raw(self._raw, geometry)

    def position(self, number):
        """Which of the pictures frame ``number`` shows."""
        return 0

    def raw(self, position):
        """Raw uint8 (height, width) frame of that light at the reference exposure."""
        return self._raw


class MovingScene:
    """The built-in scene, moved a little from frame to frame, through the lens of a descriptor.

    The scene is flat in the corrected picture; the descriptor's map, inverted between knots, bends
    it. So a device of any descriptor shows something that its correction makes straight.
    """
    def __init__(self, descriptor):
        self._geometry = geometry = descriptor.geometry
        width, height = geometry.corrected
        self._margin = round(_MARGIN * width)
        scale, painted = 2.0 / width, []
        for top in range(-self._margin, height + self._margin, _BAND):
            v, u = np.mgrid[top:min(top + _BAND, height + self._margin),
                            -self._margin:width + self._margin]
            painted.append(scene_at(((u - width / 2) * scale).astype(np.float32),
                                    ((v - height / 2) * scale).astype(np.float32)).astype(np.uint8))
        self._world = cv2.GaussianBlur(np.concatenate(painted), (3, 3), 0)
        self._map = _inverse(descriptor)

    def position(self, number):
        """Which of the pictures frame ``number`` shows: each one twice."""
        return number // 2 % POSITIONS

    def raw(self, position):
        """Raw uint8 (height, width) frame of that light at the reference exposure."""
        angle = 2 * np.pi * position / POSITIONS
        swing = _SWING * self._geometry.corrected_width
        x = self._map[0] + np.float32(self._margin + swing * np.sin(angle))
        y = self._map[1] + np.float32(self._margin + swing / 2 * np.cos(angle))
        light = cv2.remap(self._world, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT)
        return mosaic(light, self._geometry.bayer)


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


def _inverse(descriptor):
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
