"""The valid region: the corrected pixels with a source."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.nearest import Nearest
from ncdc_spec.geometry import ValidRows

__all__ = ["Calibrated", "Covering", "Masks", "REACH", "connected", "grid_pitch", "grown",
           "lost_pixels", "masks_of", "valid_mask", "valid_rows"]

REACH = 2.0            # grid pitches beyond the calibrated points that count as covered
_PIXELS = 1 << 15      # corrected pixels at a time, in whole rows: they stay in the cache


@dataclass(frozen=True)
class Calibrated:
    """The part of the map that calibrated points cover.

    A pixel is covered if its source lies in the convex hull of the points in the distorted
    image, or if it is at most ``reach`` from a calibrated point in the corrected image. The hull
    is taken in the distorted image, a rectangle that a target can fill; in the corrected one it is
    a concave pincushion. The distance is taken in the corrected image, since a network that
    saturates beyond its points maps distant pixels to few distorted ones.

    Parameters
    ----------
    u, v : ndarray, shape (N,)
        Corrected pixels.
    x, y : ndarray, shape (N,)
        Distorted pixels.
    reach : float
        Corrected pixels; training uses :data:`REACH` times :func:`grid_pitch`.
    """
    u: np.ndarray
    v: np.ndarray
    x: np.ndarray
    y: np.ndarray
    reach: float

    def covering(self, geometry):
        """The :class:`Covering` of a frame."""
        points = np.round(np.stack([self.x, self.y], axis=1)).astype(np.int32)
        return Covering(self._near(geometry), cv2.convexHull(points)[:, 0], geometry.distorted)

    def mask(self, map_function, geometry):
        """Pixels that the points cover: bool (corrected height, width)."""
        return masks_of(map_function, geometry, self.covering(geometry)).covered

    def _near(self, geometry):
        """Pixels within ``reach`` of a point: bool (corrected height, width)."""
        width, height = geometry.corrected
        # Points beyond the frame's edge cover pixels inside: measure on a larger canvas.
        margin = int(np.ceil(self.reach)) + 1
        canvas = np.ones((height + 2 * margin, width + 2 * margin), np.uint8)
        column = np.round(self.u).astype(np.int64) + margin
        row = np.round(self.v).astype(np.int64) + margin
        on = (column >= 0) & (column < canvas.shape[1]) & (row >= 0) & (row < canvas.shape[0])
        if not on.any():
            return np.zeros((height, width), bool)
        canvas[row[on], column[on]] = 0
        distance = cv2.distanceTransform(canvas, cv2.DIST_L2, cv2.DIST_MASK_PRECISE)
        return distance[margin:-margin, margin:-margin] <= self.reach


class Covering:
    """Which pixels of a frame points cover.

    Parameters
    ----------
    near : ndarray of bool, shape (height, width)
        Corrected pixels near a point.
    hull : ndarray of int, shape (n, 2)
        Corners of the hull of the points in the distorted image.
    size : (int, int)
        Width and height of the distorted image.
    """

    def __init__(self, near, hull, size):
        self.near, self._corners = near, hull.astype(np.float64)
        mask = np.zeros(size[::-1], np.uint8)
        cv2.fillConvexPoly(mask, hull, 1)
        self._hull = mask.astype(bool)

    def __call__(self, where, x, y, inside):
        """The covered ones, bool, of the corrected pixels ``where`` (an index of a picture).

        ``x`` and ``y`` are their sources, and ``inside`` whether their windows lie in the image.
        """
        column = np.where(inside, x, 0).round().astype(np.int64)
        row = np.where(inside, y, 0).round().astype(np.int64)
        return inside & (self._hull[row, column] | self.near[where])

    def hull_of(self, x, y, margin):
        """Cells that lie in the hull, and those beyond one of its sides, by the ``margin``.

        ``x``, ``y``: sources of the corners of cells, (rows + 1, columns + 1); ``margin``: pixels,
        (rows, columns).
        """
        sides = np.stack([self._corners, np.roll(self._corners, -1, axis=0)], axis=1)
        middle = self._corners.mean(axis=0)
        within = np.full(margin.shape, len(sides) > 2)
        beyond = np.zeros(margin.shape, bool)
        for first, second in sides if len(sides) > 1 else ():
            dx, dy = (second - first) / np.linalg.norm(second - first)
            inwards = np.sign(dx * (middle[1] - first[1]) - dy * (middle[0] - first[0]))
            off = inwards * (dx * (y - first[1]) - dy * (x - first[0]))
            corners = [off[i:len(off) - 1 + i, j:off.shape[1] - 1 + j]
                       for i in (0, 1) for j in (0, 1)]
            within &= np.minimum.reduce(corners) > margin
            beyond |= np.maximum.reduce(corners) < -margin
        return within, beyond


def grid_pitch(photos):
    """Median distance of a point to its nearest neighbour on the same photo.

    ``photos``: sequence of (u, v), the corrected pixels of each photo's points. Photos count
    separately because the points of two may be close together. The pitch of one point is 0.
    """
    nearest = [Nearest(np.stack([u, v], axis=1)).query(np.stack([u, v], axis=1), 2)[0][:, 1]
               for u, v in photos if len(u) > 1]
    return float(np.median(np.concatenate(nearest))) if nearest else 0.0


@dataclass(frozen=True)
class Masks:
    """Corrected pixels by their sources: bool (height, width) each.

    ``inside``: the window of the source lies in the distorted image; ``unfolded``: besides, the
    map does not fold back there; ``covered``: calibrated points cover it (None if not asked for).
    """
    inside: np.ndarray
    unfolded: np.ndarray
    covered: np.ndarray | None


def masks_of(map_function, geometry, covering=None):
    """:class:`Masks` of a map, which is evaluated once.

    ``covering``: of :meth:`Calibrated.covering`. Other arguments as of
    :func:`valid_mask`.
    """
    shape = geometry.corrected[::-1]
    inside, unfolded = np.empty(shape, bool), np.empty(shape, bool)
    covered = None if covering is None else np.empty(shape, bool)
    for rows, own, x, y in _bands(map_function, geometry):
        # Without a source at a neighbour there is no derivative, and no fold is detected.
        folded = (np.gradient(x, axis=1)[own] * np.gradient(y, axis=0)[own]
                  - np.gradient(x, axis=0)[own] * np.gradient(y, axis=1)[own]) <= 0
        x, y = x[own], y[own]
        inside[rows] = geometry.window_inside(x, y)
        unfolded[rows] = inside[rows] & ~folded
        if covered is not None:
            covered[rows] = covering(rows, x, y, inside[rows])
    return Masks(inside, unfolded, covered)


def valid_mask(map_function, geometry, within=None):
    """Corrected pixels that have a source: bool (height, width).

    A pixel is valid if the 3x3 window of its source lies in the distorted image
    (:meth:`Geometry.window_inside`), the map does not fold back there (its Jacobian determinant
    is positive), and it is connected (4-neighbourhood) to the middle of the corrected image
    through such pixels; if the middle has no source, the largest connected region counts.

    Parameters
    ----------
    map_function : callable
        (x, y) distorted pixels of arrays (u, v) of corrected pixels; not-a-number where there
        is no source. The camera's exact map if it is known, else the float network.
    geometry : Geometry
    within : ndarray of bool, shape (height, width), optional
        Pixels that can have a source at all.
    """
    mask = masks_of(map_function, geometry).unfolded
    return connected(mask if within is None else mask & within)


def _bands(map_function, geometry):
    """Bands of the frame with a row more on either side: (rows of the frame, their rows in the
    band, x, y), the first two slices."""
    width, height = geometry.corrected
    step = max(1, _PIXELS // width)
    for top in range(0, height, step):
        rows = slice(top, min(top + step, height))
        first = max(top - 1, 0)
        v = np.arange(first, min(rows.stop + 1, height), dtype=np.float64)
        v, u = np.meshgrid(v, np.arange(width, dtype=np.float64), indexing="ij")
        yield rows, slice(top - first, rows.stop - first), *map_function(u, v)


def connected(mask):
    """The part of ``mask`` that is connected to its middle, or its largest part."""
    count, labels = cv2.connectedComponents(mask.astype(np.uint8), connectivity=4)
    middle = labels[mask.shape[0] // 2, mask.shape[1] // 2]
    if not middle and count > 1:
        middle = 1 + np.bincount(labels[mask], minlength=count)[1:].argmax()
    return (labels == middle) & mask


def valid_rows(map_function, geometry, within=None):
    """:func:`valid_mask` as :class:`ValidRows`, at most two spans a row."""
    return ValidRows.of_mask(valid_mask(map_function, geometry, within))


def grown(mask, distance):
    """``mask`` and the pixels at most ``distance`` pixels from it."""
    if not mask.any():
        return mask.copy()
    return cv2.distanceTransform((~mask).astype(np.uint8), cv2.DIST_L2,
                                 cv2.DIST_MASK_PRECISE) <= distance


def lost_pixels(mask, rows):
    """Number of pixels of ``mask`` that the spans ``rows`` do not include."""
    return int((mask & ~rows.mask(mask.shape[1])).sum())
