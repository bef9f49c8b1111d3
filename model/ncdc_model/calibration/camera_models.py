"""Lens models of OpenCV, ROS and BoofCV files: ideal point to distorted pixel and back."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.errors import InputError
from ncdc_model.geometry import MAX_SIZE
from ncdc_model.lens.inverse import planar_inverse

__all__ = ["FileLens", "lens_of_table"]

_MATRIX = ("camera_matrix", "cameraMatrix", "intrinsic_matrix", "K", "k")
_COEFFICIENTS = ("distortion_coefficients", "distCoeffs", "dist_coeffs", "D", "d")
_MODEL = ("distortion_model", "camera_model", "model")
_SIZE = {"width": ("image_width", "imageWidth", "width"),
         "height": ("image_height", "imageHeight", "height")}
_PERSPECTIVE = {"plumb_bob": (4, 5), "rational_polynomial": (8,), "thin_prism": (12,),
                "pinhole": (4, 5, 8, 12, 14), "opencv": (4, 5, 8, 12, 14),
                "brown": (4, 5, 8, 12, 14), "brown_conrady": (4, 5, 8, 12, 14)}
_FISHEYE = ("fisheye", "equidistant", "kannala_brandt", "opencv_fisheye")


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


def lens_of_table(table):
    """:class:`FileLens` of a camera file's names and values.

    Models: OpenCV's perspective one with 4, 5, 8, 12 or 14 coefficients (k1 k2 p1 p2 k3 k4 k5
    k6 s1 s2 s3 s4 tx ty; ROS's plumb_bob and rational_polynomial), OpenCV's fisheye with 4 (ROS's
    equidistant), and BoofCV's omnidirectional_universal. Which one is told by distortion_model,
    camera_model or model; without it 4 coefficients named D beside a matrix named K are
    a fisheye's, as OpenCV's documentation writes them, and others are perspective.

    Raises
    ------
    InputError
        If a value is missing, of the wrong kind or not finite, or the model is unknown.
    """
    try:
        name = str(_first(table, _MODEL, "")).lower()
        if name == "omnidirectional_universal":
            size, matrix, bend = _omnidirectional(table)
            model = name
        else:
            size = tuple(_whole(_first(table, names), side) for side, names in _SIZE.items())
            matrix = _numbers(_first(table, _MATRIX), "camera matrix", (9,)).reshape(3, 3)
            coefficients = _numbers(_first(table, _COEFFICIENTS), "distortion coefficients")
            model, bend = _opencv(table, name, coefficients)
    except KeyError as error:
        raise InputError(f"the camera lacks the value {error.args[0]}") from error
    except InputError:
        raise
    except (TypeError, ValueError, AttributeError) as error:
        raise InputError(f"the camera holds a value of the wrong kind: {error}") from error
    if not (matrix[0, 0] > 0 and matrix[1, 1] > 0):
        raise InputError(f"the focal lengths are {matrix[0, 0]:g} and {matrix[1, 1]:g}, "
                         f"they must be positive")
    return FileLens(size, matrix, bend, model, _fold(bend))


def _opencv(table, name, coefficients):
    count = len(coefficients)
    fisheye = name in _FISHEYE or bool(_first(table, ("fisheye_model",), 0))
    if not name and count == 4 and "K" in table and "D" in table:
        fisheye = True
    if fisheye:
        if count != 4:
            raise InputError(f"the fisheye model has {count} coefficients, 4 are needed")
        return "fisheye", lambda a, b: _fisheye(a, b, coefficients)
    if name and name not in _PERSPECTIVE:
        known = ", ".join([*_PERSPECTIVE, *_FISHEYE, "omnidirectional_universal"])
        raise InputError(f"the distortion model is {name!r}, one of {known} is needed")
    allowed = _PERSPECTIVE[name or "opencv"]
    if count not in allowed:
        raise InputError(f"the model {name or 'opencv'} has {count} coefficients, "
                         f"{' or '.join(map(str, allowed))} are needed")
    return f"perspective with {count} coefficients", lambda a, b: _perspective(a, b, coefficients)


def _perspective(a, b, coefficients):
    points = np.stack([a, b, np.ones_like(a)], axis=-1).reshape(-1, 1, 3)
    none = np.zeros(3)
    result = cv2.projectPoints(points, none, none, np.eye(3), coefficients)[0].reshape(-1, 2)
    return result[:, 0].reshape(np.shape(a)), result[:, 1].reshape(np.shape(a))


def _fisheye(a, b, coefficients):
    points = np.stack([a, b], axis=-1).reshape(-1, 1, 2)
    result = cv2.fisheye.distortPoints(points, np.eye(3), coefficients).reshape(-1, 2)
    return result[:, 0].reshape(np.shape(a)), result[:, 1].reshape(np.shape(a))


def _omnidirectional(table):
    """Unified model of Geyer, Barreto and Mei: unit sphere, shifted pinhole, radial, tangential."""
    pinhole, bends = table["pinhole"], table["radial_tangential"]
    size = _whole(pinhole["width"], "width"), _whole(pinhole["height"], "height")
    fx, fy, cx, cy, skew, t1, t2, offset = _numbers(
        [pinhole["fx"], pinhole["fy"], pinhole["cx"], pinhole["cy"], pinhole.get("skew", 0.0),
         bends.get("t1", 0.0), bends.get("t2", 0.0), table["mirror_offset"]], "camera", (8,))
    radial = _numbers(bends.get("radial") or [0.0], "radial coefficients")

    def bend(a, b):
        z = 1 + offset * np.sqrt(a * a + b * b + 1)
        x, y = a / z, b / z
        q = x * x + y * y
        scale = 1 + sum(k * q**power for power, k in enumerate(radial, 1))
        return (x * scale + 2 * t1 * x * y + t2 * (q + 2 * x * x),
                y * scale + t1 * (q + 2 * y * y) + 2 * t2 * x * y)
    return size, np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]]), bend


def _fold(bend):
    """Radius of the ideal plane before which the distorted radius grows in every direction."""
    angle = np.arange(0, 16) * np.pi / 8
    # Equal steps in view angle up to 89.6 degrees.
    radius = np.tan(np.linspace(0, 1.564, 1500))
    x, y = bend(*(np.outer(part, radius) for part in (np.cos(angle), np.sin(angle))))
    grown = np.hypot(x - x[:, :1], y - y[:, :1])
    falls = ~(np.diff(grown, axis=1) > 0)
    return float(radius[falls.argmax(axis=1)[falls.any(axis=1)].min()]) if falls.any() else np.inf


_REQUIRED = object()


def _first(table, names, default=_REQUIRED):
    for name in names:
        if name in table and table[name] is not None:
            return table[name]
    if default is _REQUIRED:
        raise KeyError(" or ".join(names))
    return default


def _numbers(value, name, shape=None):
    if isinstance(value, dict):
        value = value["data"]
    array = np.array(value, np.float64).ravel()
    if shape is not None and array.shape != shape:
        raise InputError(f"the {name} has {array.size} numbers, {shape[0]} are needed")
    if not np.isfinite(array).all():
        raise InputError(f"the {name} holds a number that is not finite")
    return array


def _whole(value, name):
    number = float(value)
    if number != int(number) or not 8 <= number <= MAX_SIZE:
        raise InputError(f"the image {name} is {number:g}, the limits are 8 and {MAX_SIZE}")
    return int(number)
