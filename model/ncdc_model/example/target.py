"""The example's calibration target: a page of black dots on white, and its photo."""

import numpy as np

from ncdc_model.example.camera import BAYER
from ncdc_model.example.render import SUBSAMPLES, expose, ideal_samples, sensor

__all__ = ["COLUMNS", "PAGE_TO_IDEAL", "PITCH", "RADIUS", "ROWS", "page_dots", "page_to_distorted",
           "target_photo"]

COLUMNS, ROWS = 31, 23     # dots
PITCH = 10.0               # millimetres between neighbouring dots
RADIUS = 2.3               # millimetres
_BAND = 32 * SUBSAMPLES    # rows of subsamples at a time: each needs 100 bytes temporarily

# Homography from the page (millimetres, origin in its middle) to the ideal plane of the camera:
# the page is turned by 0.7 degrees in its plane and tilted by about 3 degrees.
PAGE_TO_IDEAL = np.array([[0.01200, -0.00015, -0.025], [0.00015, 0.01195, 0.012],
                          [0.00022, -0.00030, 1.0]])


def page_dots():
    """Page coordinates in millimetres of the dots' centres, shape (ROWS, COLUMNS, 2).

    Element [j, i] is the dot of column i and row j.
    """
    i, j = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    return PITCH * np.stack([i - (COLUMNS - 1) / 2, j - (ROWS - 1) / 2], axis=-1)


def page_to_distorted(camera, page_xy):
    """Exact distorted pixels (..., 2) of points (..., 2) of the page, in millimetres."""
    page_xy = np.asarray(page_xy, np.float64)
    a, b, w = np.moveaxis(page_xy @ PAGE_TO_IDEAL[:, :2].T + PAGE_TO_IDEAL[:, 2], -1, 0)
    return np.stack(camera.distort(a / w, b / w), axis=-1)


def target_photo(camera, seed=1, bayer=BAYER, plane=PAGE_TO_IDEAL):
    """Raw uint8 photo (height, width) of the page by ``camera``, deterministic for ``seed``.

    ``plane``: homography (3, 3) from the page to the camera's ideal plane.

    Warm light from the upper left falls off to the corners by half; sensor noise as in
    :func:`sensor`.
    """
    a, b = ideal_samples(camera)
    edge = np.empty_like(a)
    bands = [slice(top, top + _BAND) for top in range(0, len(a), _BAND)]
    for rows in bands:
        edge[rows] = _edge(a[rows], b[rows], plane)
    del a, b
    page = np.concatenate([expose(0.88 - 0.82 * _ink(edge, rows)) for rows in bands])
    height, width = camera.size[1], camera.size[0]
    x, y = np.meshgrid(np.arange(width) / width - 0.5, np.arange(height) / width - 0.375)
    lamp = 1.0 - 0.25 * (x + y) - 0.85 * (x * x + y * y)
    light = 215 * (page * lamp)[:, :, None] * np.array([0.96, 1.0, 0.78])
    return sensor(light, bayer, seed)


def _edge(a, b, plane):
    """Distance in millimetres from ideal points to the edge of the nearest dot, negative inside."""
    back = np.linalg.inv(plane)
    w = back[2, 0] * a + back[2, 1] * b + back[2, 2]
    page_x = (back[0, 0] * a + back[0, 1] * b + back[0, 2]) / w
    page_y = (back[1, 0] * a + back[1, 1] * b + back[1, 2]) / w
    i = np.clip(np.round(page_x / PITCH), -(COLUMNS // 2), COLUMNS // 2)
    j = np.clip(np.round(page_y / PITCH), -(ROWS // 2), ROWS // 2)
    return np.hypot(page_x - PITCH * i, page_y - PITCH * j) - RADIUS


def _ink(edge, rows):
    """Part of ink, 0 to 1, of the subsamples in a slice of rows of ``edge``.

    The distance is divided by its change per subsample: an edge one subsample wide, so that the
    coverage of a pixel is not a multiple of 1/9.
    """
    first = max(0, rows.start - 1)
    part = edge[first:rows.stop + 1]             # one more row on either side, for the change
    slope = np.hypot(*np.gradient(part))
    ink = np.clip(0.5 - part / np.maximum(slope, 1e-9), 0, 1)
    return ink[rows.start - first:][:len(edge[rows])]
