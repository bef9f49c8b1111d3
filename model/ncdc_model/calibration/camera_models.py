"""Lens models of OpenCV, ROS, BoofCV and Kalibr files, told apart by what the files hold."""

import numpy as np

from ncdc_model.calibration.camera_kalibr import is_camchain, kalibr_lens
from ncdc_model.calibration.file_lens import (
    file_lens,
    fisheye,
    numbers,
    perspective,
    unified_sphere,
    whole,
)
from ncdc_model.errors import InputError

__all__ = ["lens_of_table"]

_MATRIX = ("camera_matrix", "cameraMatrix", "intrinsic_matrix", "K", "k")
_COEFFICIENTS = ("distortion_coefficients", "distCoeffs", "dist_coeffs", "D", "d")
_MODEL = ("distortion_model", "camera_model", "model")
_SIZE = {"width": ("image_width", "imageWidth", "width"),
         "height": ("image_height", "imageHeight", "height")}
_PERSPECTIVE = {"plumb_bob": (4, 5), "rational_polynomial": (8,), "thin_prism": (12,),
                "pinhole": (4, 5, 8, 12, 14), "opencv": (4, 5, 8, 12, 14),
                "brown": (4, 5, 8, 12, 14), "brown_conrady": (4, 5, 8, 12, 14)}
_FISHEYE = ("fisheye", "equidistant", "kannala_brandt", "opencv_fisheye")


def lens_of_table(table, camera=None):
    """:class:`FileLens` of a camera file's names and values.

    Models: OpenCV's perspective one with 4, 5, 8, 12 or 14 coefficients (k1 k2 p1 p2 k3 k4 k5
    k6 s1 s2 s3 s4 tx ty; ROS's plumb_bob and rational_polynomial), OpenCV's fisheye with 4 (ROS's
    equidistant), and BoofCV's omnidirectional_universal. Which one is told by distortion_model,
    camera_model or model; without it 4 coefficients named D beside a matrix named K are
    a fisheye's, as OpenCV's documentation writes them, and others are perspective. A camchain of
    Kalibr: see :func:`ncdc_model.calibration.camera_kalibr.kalibr_lens`; ``camera`` chooses one
    of a chain.

    Raises
    ------
    InputError
        If a value is missing, of the wrong kind or not finite, the model is unknown, or
        ``camera`` is given for a file of one camera.
    """
    try:
        if is_camchain(table):
            return file_lens(*kalibr_lens(table, camera))
        if camera is not None:
            raise InputError(f"camera {camera} is asked for, the file holds one camera without "
                             f"a name")
        name = str(_first(table, _MODEL, "")).lower()
        if name == "omnidirectional_universal":
            size, matrix, bend = _omnidirectional(table)
            model = name
        else:
            size = tuple(whole(_first(table, names), side) for side, names in _SIZE.items())
            matrix = numbers(_first(table, _MATRIX), "camera matrix", (9,)).reshape(3, 3)
            coefficients = numbers(_first(table, _COEFFICIENTS), "distortion coefficients")
            model, bend = _opencv(table, name, coefficients)
    except KeyError as error:
        raise InputError(f"the camera lacks the value {error.args[0]}") from error
    except InputError:
        raise
    except (TypeError, ValueError, AttributeError, OverflowError) as error:
        raise InputError(f"the camera holds a value of the wrong kind: {error}") from error
    return file_lens(size, matrix, bend, model)


def _opencv(table, name, coefficients):
    count = len(coefficients)
    wide = name in _FISHEYE or bool(_first(table, ("fisheye_model",), 0))
    if not name and count == 4 and "K" in table and "D" in table:
        wide = True
    if wide:
        if count != 4:
            raise InputError(f"the fisheye model has {count} coefficients, 4 are needed")
        return "fisheye", lambda a, b: fisheye(a, b, coefficients)
    if name and name not in _PERSPECTIVE:
        known = ", ".join([*_PERSPECTIVE, *_FISHEYE, "omnidirectional_universal"])
        raise InputError(f"the distortion model is {name!r}, one of {known} is needed")
    allowed = _PERSPECTIVE[name or "opencv"]
    if count not in allowed:
        raise InputError(f"the model {name or 'opencv'} has {count} coefficients, "
                         f"{' or '.join(map(str, allowed))} are needed")
    return f"perspective with {count} coefficients", lambda a, b: perspective(a, b, coefficients)


def _omnidirectional(table):
    pinhole, bends = table["pinhole"], table["radial_tangential"]
    size = whole(pinhole["width"], "width"), whole(pinhole["height"], "height")
    fx, fy, cx, cy, skew, t1, t2, offset = numbers(
        [pinhole["fx"], pinhole["fy"], pinhole["cx"], pinhole["cy"], pinhole.get("skew", 0.0),
         bends.get("t1", 0.0), bends.get("t2", 0.0), table["mirror_offset"]], "camera", (8,))
    radial = numbers(bends.get("radial") or [0.0], "radial coefficients")
    return size, np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]]), lambda a, b: unified_sphere(
        a, b, offset, radial, (t1, t2))


_REQUIRED = object()


def _first(table, names, default=_REQUIRED):
    for name in names:
        if name in table and table[name] is not None:
            return table[name]
    if default is _REQUIRED:
        raise KeyError(" or ".join(names))
    return default
