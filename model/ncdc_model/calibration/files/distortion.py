"""Lens models of camera files: distorted point of an ideal one, in units of the focal length."""

import cv2
import numpy as np

from ncdc_spec.errors import InputError

__all__ = ["division", "field_of_view", "fisheye", "modified_brown", "on_angle", "perspective",
           "unified_sphere"]


def perspective(a, b, coefficients):
    """OpenCV's perspective model with 4, 5, 8, 12 or 14 coefficients."""
    points = np.stack([a, b, np.ones_like(a)], axis=-1).reshape(-1, 1, 3)
    none = np.zeros(3)
    result = cv2.projectPoints(points, none, none, np.eye(3), coefficients)[0].reshape(-1, 2)
    return result[:, 0].reshape(np.shape(a)), result[:, 1].reshape(np.shape(a))


def fisheye(a, b, coefficients):
    """OpenCV's fisheye model with 4 coefficients: a polynomial of the view angle."""
    points = np.stack([a, b], axis=-1).reshape(-1, 1, 2)
    result = cv2.fisheye.distortPoints(points, np.eye(3), coefficients).reshape(-1, 2)
    return result[:, 0].reshape(np.shape(a)), result[:, 1].reshape(np.shape(a))


def on_angle(a, b, radial, tangential=(0, 0), prism=(0, 0)):
    """COLMAP's fisheyes: the view angle as radius, then radial, tangential and prism terms of it.

    ``radial``: of ascending even powers; ``prism``: of the squared radius, on x and on y.
    """
    r = np.hypot(a, b)
    scale = np.where(r > 0, np.arctan(r) / np.where(r > 0, r, 1), 1)
    x, y = _brown(a * scale, b * scale, radial, tangential)
    q = np.arctan(r)**2
    return x + prism[0] * q, y + prism[1] * q


def unified_sphere(a, b, offset, radial, tangential=(0, 0)):
    """Unified model of Geyer, Barreto and Mei: unit sphere, pinhole ``offset`` from its centre,
    radial distortion of ascending even powers, tangential distortion as in OpenCV."""
    z = 1 + offset * np.sqrt(a * a + b * b + 1)
    return _brown(a / z, b / z, radial, tangential)


def _brown(x, y, radial, tangential):
    q = x * x + y * y
    scale = 1 + sum(k * q**power for power, k in enumerate(radial, 1))
    t1, t2 = tangential
    return (x * scale + 2 * t1 * x * y + t2 * (q + 2 * x * x),
            y * scale + t1 * (q + 2 * y * y) + 2 * t2 * x * y)


def modified_brown(a, b, coefficients):
    """librealsense's modified Brown-Conrady: tangential terms of the radially distorted point."""
    k1, k2, t1, t2, k3 = coefficients
    q = a * a + b * b
    scale = 1 + q * (k1 + q * (k2 + q * k3))
    x, y = a * scale, b * scale
    return (x + 2 * t1 * x * y + t2 * (q + 2 * x * x),
            y + t1 * (q + 2 * y * y) + 2 * t2 * x * y)


def division(a, b, coefficients):
    """Division model: the ideal point is the distorted one of radius r over 1 + k r r."""
    k, = coefficients
    with np.errstate(invalid="ignore"):
        scale = 2 / (1 + np.sqrt(1 - 4 * k * (a * a + b * b)))
    return a * scale, b * scale


def field_of_view(a, b, w):
    """Devernay and Faugeras: distorted radius atan(2 r tan(w / 2)) / w."""
    if not 0 < w < np.pi:
        raise InputError(f"the field of view is {w:g} rad, it must lie between 0 and pi")
    r = np.hypot(a, b)
    scale = np.where(r > 0, np.arctan(2 * r * np.tan(w / 2)) / (w * np.where(r > 0, r, 1)),
                     2 * np.tan(w / 2) / w)
    return a * scale, b * scale
