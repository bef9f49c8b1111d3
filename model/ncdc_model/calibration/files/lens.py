"""A lens read from another program's camera file, and functions that its readers share."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_model.lens.inverse import planar_inverse
from ncdc_spec.errors import InputError

__all__ = ["UNBENT", "FileLens", "choose", "coefficients", "file_lens", "flag", "matrix_of",
           "numbers", "single", "whole"]

UNBENT = "the file holds no distortion coefficients: a lens without distortion is taken"


@dataclass(frozen=True)
class FileLens:
    """A lens read from a file.

    Parameters
    ----------
    size : (int, int) or None
        Width and height of the distorted image; None if the file does not say.
    matrix : ndarray, shape (3, 3)
        Intrinsic parameters, equation (2) of the paper. Pixel centres are integers.
    distortion : callable
        Distorted point, in units of the focal length, of ideal points (a, b).
    model : str
        Name for reports.
    limit : float
        Radius of the ideal plane at which the model folds back.
    rotation : ndarray, shape (3, 3), optional
        Rectification: takes directions of the camera to those of the corrected
        picture. All points (a, b) outside of ``distortion`` are of the rotated plane.
    frame : Frame, optional
        The corrected picture that the file describes.
    notes, warnings : tuple of str
        Sentences on how the file was read, and on what is odd about it.
    """
    size: tuple | None
    matrix: np.ndarray
    distortion: object
    model: str
    limit: float
    rotation: np.ndarray | None = None
    frame: object = None
    notes: tuple = ()
    warnings: tuple = ()

    def distort(self, a, b):
        """Distorted pixel of the ideal point (a, b); not-a-number where the model folds back."""
        a, b = np.broadcast_arrays(np.asarray(a, np.float64), np.asarray(b, np.float64))
        if self.rotation is not None:
            a, b = _turned(np.linalg.inv(self.rotation), a, b)
        good = np.hypot(a, b) < self.limit
        with np.errstate(all="ignore"):
            x, y = self.distortion(np.where(good, a, 0), np.where(good, b, 0))
        k = self.matrix
        return (np.where(good, k[0, 0] * x + k[0, 1] * y + k[0, 2], np.nan),
                np.where(good, k[1, 1] * y + k[1, 2], np.nan))

    def undistort(self, x, y):
        """Ideal point of the distorted pixel (x, y); not-a-number where there is none."""
        k = self.matrix
        y = (np.asarray(y, np.float64) - k[1, 2]) / k[1, 1]
        x = (np.asarray(x, np.float64) - k[0, 2] - k[0, 1] * y) / k[0, 0]

        def inside(a, b):
            xb, yb = self.distortion(a, b)
            good = np.hypot(a, b) < self.limit
            return np.where(good, xb, np.nan), np.where(good, yb, np.nan)
        a, b = planar_inverse(inside, x, y, iterations=60)
        return (a, b) if self.rotation is None else _turned(self.rotation, a, b)

    def moved(self, size, scale, shift):
        """The lens of an image of ``size`` whose pixels are ``scale`` (x, y) + ``shift``."""
        to = np.array([[scale[0], 0, shift[0]], [0, scale[1], shift[1]], [0, 0, 1]])
        frame = self.frame and replace(
            self.frame, size=tuple(size), focal=scale[0] * self.frame.focal,
            centre=tuple(float(s * c + d) for s, c, d in zip(scale, self.frame.centre, shift)),
            aspect=self.frame.aspect * scale[1] / scale[0])
        return replace(self, size=tuple(size), matrix=to @ self.matrix, frame=frame)


def _turned(rotation, a, b):
    """Points of the ideal plane after ``rotation``; not-a-number if not in front of it."""
    x, y, z = np.einsum("ij,j...->i...", rotation, np.stack([a, b, np.ones_like(a)]))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(z > 0, x / z, np.nan), np.where(z > 0, y / z, np.nan)


def file_lens(size, matrix, distortion, model, **more):
    """:class:`FileLens` with its limit; :class:`InputError` if a focal length is not positive."""
    if not (matrix[0, 0] > 0 and matrix[1, 1] > 0):
        raise InputError(f"the focal lengths are {matrix[0, 0]:g} and {matrix[1, 1]:g}, "
                         f"they must be positive")
    return FileLens(size, matrix, distortion, model, _fold(distortion), **more)


def _fold(distortion):
    """Radius of the ideal plane before which the distorted radius grows in every direction."""
    angle = np.arange(0, 16) * np.pi / 8
    # Equal steps in view angle up to 89.6 degrees.
    radius = np.tan(np.linspace(0, 1.564, 1500))
    with np.errstate(all="ignore"):
        x, y = distortion(*(np.outer(part, radius) for part in (np.cos(angle), np.sin(angle))))
        grown = np.hypot(x - x[:, :1], y - y[:, :1])
    falls = ~(np.diff(grown, axis=1) > 0)
    return float(radius[falls.argmax(axis=1)[falls.any(axis=1)].min()]) if falls.any() else np.inf


def choose(names, camera, what="cameras"):
    """The one of ``names`` that ``camera`` chooses; it may be None if there is only one.

    Raises
    ------
    InputError
        If there are several and none is chosen, or the chosen one is absent.
    """
    names = [str(name) for name in names]
    shown = ", ".join(names[:12]) + (f" and {len(names) - 12} more" if len(names) > 12 else "")
    if camera is None and len(names) > 1:
        raise InputError(f"the file holds the {what} {shown}, one must be chosen with --camera")
    if camera is not None and camera not in names:
        raise InputError(f"camera {camera} is asked for, the file holds {shown}")
    return camera if camera is not None else names[0]


def matrix_of(fx, fy, cx, cy, skew=0.0):
    """Matrix (3, 3) of focal lengths and principal point, finite floats."""
    fx, fy, cx, cy, skew = numbers([fx, fy, cx, cy, skew], "list of focal lengths and centre", (5,))
    return np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]])


def _holds_bool(value):
    if isinstance(value, (list, tuple)):
        return any(map(_holds_bool, value))
    return isinstance(value, (bool, np.bool_)) or getattr(value, "dtype", None) is np.dtype(bool)


def numbers(value, name, shape=None):
    """``value`` as flat finite floats; :class:`InputError` unless of ``shape``, or if a value is
    true or false."""
    if isinstance(value, dict):
        value = value["data"]
    if _holds_bool(value):
        raise InputError(f"the {name} holds true or false, numbers are needed")
    array = np.array(value, np.float64).ravel()
    if shape is not None and array.shape != shape:
        raise InputError(f"the {name} has {array.size} numbers, {shape[0]} are needed")
    if not np.isfinite(array).all():
        raise InputError(f"the {name} holds a number that is not finite")
    return array


def coefficients(value, model, allowed):
    """``value`` as distortion coefficients, one of the numbers ``allowed`` of them.

    Trailing zeros are removed. No coefficients are read as zeros.

    Raises
    ------
    InputError
        If their number is another.
    """
    k = numbers([] if value is None else value, "list of distortion coefficients")
    if not k.any():
        return k if len(k) in allowed else np.zeros(allowed[0])
    last = int(np.flatnonzero(k)[-1])
    fitting = [n for n in (len(k), *allowed) if n in allowed and last < n <= len(k)]
    if not fitting:
        raise InputError(f"the model {model} has {len(k)} coefficients, "
                         f"{' or '.join(map(str, allowed))} are needed")
    return k[:fitting[0]]


def single(value, name):
    """``value`` as a finite float, for a reader that has its own sentence on what is needed."""
    if _holds_bool(value):
        raise InputError(f"the {name} is {str(value).lower()}, a number is needed")
    return float(value)


def flag(value, name):
    """Whether ``value``, true or false in any of the notations of the formats, is true."""
    text = str(value).lower()
    if text not in ("true", "false", "0", "1", "0.0", "1.0", "none"):
        raise InputError(f"{name} is {' '.join(repr(value).split())[:60]}, true or false is needed")
    return text in ("true", "1", "1.0")


def whole(value, name):
    """``value`` as a side of an image, in pixels."""
    number = single(value, f"image {name}")
    if number != int(number) or number < 1:
        raise InputError(f"the image {name} is {number:g}, a whole number of pixels is needed")
    return int(number)
