"""A lens read from another project's camera file, and what its readers share."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.errors import InputError
from ncdc_model.geometry import MAX_SIZE
from ncdc_model.lens.inverse import planar_inverse

__all__ = ["FileLens", "file_lens", "fisheye", "numbers", "perspective", "unified_sphere", "whole"]


@dataclass(frozen=True)
class FileLens:
    """A lens read from a file.

    Parameters
    ----------
    size : (int, int)
        Width and height of the distorted image.
    matrix : ndarray, shape (3, 3)
        Intrinsic parameters, equation (2) of the paper.
    bend : callable
        Distorted point, in units of the focal length, of ideal points (a, b).
    model : str
        Name for reports.
    limit : float
        Radius of the ideal plane from which on the model folds back.
    """
    size: tuple
    matrix: np.ndarray
    bend: object
    model: str
    limit: float

    def distort(self, a, b):
        """Distorted pixel of the ideal point (a, b); not-a-number where the model folds back."""
        a, b = np.broadcast_arrays(np.asarray(a, np.float64), np.asarray(b, np.float64))
        good = np.hypot(a, b) < self.limit
        x, y = self.bend(np.where(good, a, 0), np.where(good, b, 0))
        k = self.matrix
        return (np.where(good, k[0, 0] * x + k[0, 1] * y + k[0, 2], np.nan),
                np.where(good, k[1, 1] * y + k[1, 2], np.nan))

    def undistort(self, x, y):
        """Ideal point of the distorted pixel (x, y); not-a-number where there is none."""
        k = self.matrix
        y = (np.asarray(y, np.float64) - k[1, 2]) / k[1, 1]
        x = (np.asarray(x, np.float64) - k[0, 2] - k[0, 1] * y) / k[0, 0]

        def inside(a, b):
            xb, yb = self.bend(a, b)
            good = np.hypot(a, b) < self.limit
            return np.where(good, xb, np.nan), np.where(good, yb, np.nan)
        return planar_inverse(inside, x, y, iterations=60)


def file_lens(size, matrix, bend, model):
    """:class:`FileLens` with its limit; :class:`InputError` if a focal length is not positive."""
    if not (matrix[0, 0] > 0 and matrix[1, 1] > 0):
        raise InputError(f"the focal lengths are {matrix[0, 0]:g} and {matrix[1, 1]:g}, "
                         f"they must be positive")
    return FileLens(size, matrix, bend, model, _fold(bend))


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


def unified_sphere(a, b, offset, radial, tangential=(0, 0)):
    """Unified model of Geyer, Barreto and Mei: unit sphere, pinhole ``offset`` behind its centre,
    radial distortion of ascending even powers, tangential distortion as in OpenCV."""
    z = 1 + offset * np.sqrt(a * a + b * b + 1)
    x, y = a / z, b / z
    q = x * x + y * y
    scale = 1 + sum(k * q**power for power, k in enumerate(radial, 1))
    t1, t2 = tangential
    return (x * scale + 2 * t1 * x * y + t2 * (q + 2 * x * x),
            y * scale + t1 * (q + 2 * y * y) + 2 * t2 * x * y)


def _fold(bend):
    """Radius of the ideal plane before which the distorted radius grows in every direction."""
    angle = np.arange(0, 16) * np.pi / 8
    # Equal steps in view angle up to 89.6 degrees.
    radius = np.tan(np.linspace(0, 1.564, 1500))
    x, y = bend(*(np.outer(part, radius) for part in (np.cos(angle), np.sin(angle))))
    grown = np.hypot(x - x[:, :1], y - y[:, :1])
    falls = ~(np.diff(grown, axis=1) > 0)
    return float(radius[falls.argmax(axis=1)[falls.any(axis=1)].min()]) if falls.any() else np.inf


def numbers(value, name, shape=None):
    """``value`` as flat finite floats; :class:`InputError` unless of ``shape``."""
    if isinstance(value, dict):
        value = value["data"]
    array = np.array(value, np.float64).ravel()
    if shape is not None and array.shape != shape:
        raise InputError(f"the {name} has {array.size} numbers, {shape[0]} are needed")
    if not np.isfinite(array).all():
        raise InputError(f"the {name} holds a number that is not finite")
    return array


def whole(value, name):
    """``value`` as a side of an image; :class:`InputError` outside the limits."""
    number = float(value)
    if number != int(number) or not 8 <= number <= MAX_SIZE:
        raise InputError(f"the image {name} is {number:g}, the limits are 8 and {MAX_SIZE}")
    return int(number)
