"""OpenCV's lens models: Brown's five coefficients, the full pinhole model, the fisheye model."""

import cv2
import numpy as np

from ncdc_bench.baselines.projection import fit_projection

__all__ = ["fit_brown", "fit_fisheye", "fit_full"]

# Indices in OpenCV's vector: k1 k2 p1 p2 k3, k4 k5 k6, s1 s2 s3 s4, tilt about x and y.
_BROWN = ((0, 1), (2, 3, 4))
_FULL = (*_BROWN, (5, 6, 7), (8, 9, 10, 11), (12, 13))
_FISHEYE = ((0, 1), (2, 3))
_STARTS = ((1.0, 1e-4), (1.0, 1e-2), (1.3, 1e-4), (1.3, 1e-2))


def fit_brown(points):
    """Radial terms to the sixth power and decentring: five coefficients.

    ``points``: a Problem; returns (u, v) to (x', y'), as :func:`fit_projection`.
    """
    return fit_projection(points, _pinhole, _BROWN)


def fit_full(points):
    """All coefficients of OpenCV: rational radial, decentring, thin prism, tilted sensor.

    ``points``: a Problem; returns (u, v) to (x', y'), as :func:`fit_projection`.
    """
    return fit_projection(points, _pinhole, _FULL, _STARTS)


def fit_fisheye(points):
    """Equidistant with an odd polynomial of the angle: four coefficients.

    ``points``: a Problem; returns (u, v) to (x', y'), as :func:`fit_projection`.
    """
    return fit_projection(points, _fisheye, _FISHEYE)


def _matrix(camera):
    fx, fy, cx, cy = camera
    return np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]])


def _pinhole(target, pose, camera, lens):
    # projectPoints takes vectors of 5 and 14 coefficients; its derivatives are in our order.
    pixels, slopes = cv2.projectPoints(target, pose[:3], pose[3:], _matrix(camera), lens)
    return pixels[:, 0], slopes


def _fisheye(target, pose, camera, lens):
    pixels, slopes = cv2.fisheye.projectPoints(target[:, None], pose[:3], pose[3:],
                                               _matrix(camera), lens)
    # Here the columns are f, c, k, rotation, translation, skew.
    return pixels[:, 0], np.concatenate([slopes[:, 8:14], slopes[:, :8]], axis=1)
