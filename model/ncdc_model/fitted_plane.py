"""The view of a flat picture, of which a lens alone says nothing, that fits given pixels best."""

import cv2
import numpy as np

from ncdc_spec.errors import InputError

__all__ = ["fitted_plane"]


def fitted_plane(camera, u, v, x, y):
    """The camera's map from the plane whose homography to (u, v) fits the pixels (x, y) best."""
    a, b = camera.undistort(x, y)
    known = np.isfinite(a) & np.isfinite(b)
    if known.sum() < 8:
        raise InputError(f"the camera sees {known.sum()} of {len(u)} points of the corrected "
                         f"frame, at least 8 are needed")
    u, v, x, y = (values[known] for values in (u, v, x, y))
    start = cv2.findHomography(np.stack([u, v], axis=1), np.stack([a, b], axis=1)[known], 0)[0]

    def through(matrix):
        def back_map(u, v):
            flat = np.stack([np.ravel(u), np.ravel(v)], axis=1)[:, None]
            a, b = cv2.perspectiveTransform(flat, matrix)[:, 0].T
            return camera.distort(a.reshape(np.shape(u)), b.reshape(np.shape(v)))
        return back_map

    def residuals(parameters):
        a, b = through(np.append(parameters, 1).reshape(3, 3))(u, v)
        return np.nan_to_num(np.concatenate([a - x, b - y]), nan=100.0)
    from scipy.optimize import least_squares  # a third of a second that few commands need
    fit = least_squares(residuals, (start / start[2, 2]).ravel()[:8], x_scale="jac")
    return through(np.append(fit.x, 1).reshape(3, 3))
