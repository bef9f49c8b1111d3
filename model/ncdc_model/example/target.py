"""The example's calibration target: a page of black dots on white, and its photo."""

import numpy as np

from ncdc_model.example.camera import BAYER
from ncdc_model.example.render import expose, ideal_samples, sensor

__all__ = ["COLUMNS", "PAGE_TO_IDEAL", "PITCH", "RADIUS", "ROWS", "page_dots", "page_to_distorted",
           "target_photo"]

COLUMNS, ROWS = 31, 23     # dots
PITCH = 10.0               # millimetres between neighbouring dots
RADIUS = 2.3               # millimetres

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


def target_photo(camera, seed=1, bayer=BAYER):
    """Raw uint8 photo (height, width) of the page by ``camera``, deterministic for ``seed``.

    Warm light from the upper left falls off to the corners by half; sensor noise as in
    :func:`sensor`.
    """
    a, b = ideal_samples(camera)
    back = np.linalg.inv(PAGE_TO_IDEAL)
    w = back[2, 0] * a + back[2, 1] * b + back[2, 2]
    page_x = (back[0, 0] * a + back[0, 1] * b + back[0, 2]) / w
    page_y = (back[1, 0] * a + back[1, 1] * b + back[1, 2]) / w
    # Distance to the rim of the nearest dot, over its change per subsample: an edge one
    # subsample wide, so that the coverage of a pixel is not a multiple of 1/9.
    i = np.clip(np.round(page_x / PITCH), -(COLUMNS // 2), COLUMNS // 2)
    j = np.clip(np.round(page_y / PITCH), -(ROWS // 2), ROWS // 2)
    rim = np.hypot(page_x - PITCH * i, page_y - PITCH * j) - RADIUS
    slope = np.hypot(*np.gradient(rim))
    ink = np.clip(0.5 - rim / np.maximum(slope, 1e-9), 0, 1)
    height, width = camera.size[1], camera.size[0]
    x, y = np.meshgrid(np.arange(width) / width - 0.5, np.arange(height) / width - 0.375)
    lamp = 1.0 - 0.25 * (x + y) - 0.85 * (x * x + y * y)
    page = expose(0.88 - 0.82 * ink)
    light = 215 * (page * lamp)[:, :, None] * np.array([0.96, 1.0, 0.78])
    return sensor(light, bayer, seed)
