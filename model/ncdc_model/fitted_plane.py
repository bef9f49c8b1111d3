"""The view of a flat picture, of which a lens alone says nothing, that fits given pixels best."""

import cv2
import numpy as np

from ncdc_model.calibration.descent import descend
from ncdc_spec.errors import InputError

__all__ = ["fitted_plane"]

_PROBE = 1e-6          # of a homography's number: step of a derivative
_FAR = 100.0           # pixels, of a point that the lens does not see
_NEVER = 1e6           # pixels: no residual counts linearly


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
        return np.nan_to_num(np.concatenate([a - x, b - y]), nan=_FAR)

    def derivatives(parameters):
        steps = np.diag(_PROBE * np.maximum(np.abs(parameters), _PROBE))
        return np.stack([(residuals(parameters + step) - residuals(parameters - step))
                         / (2 * step.max()) for step in steps])
    found, _ = descend(residuals, derivatives, (start / start[2, 2]).ravel()[:8], _NEVER)
    return through(np.append(found, 1).reshape(3, 3))
