"""Lenses of OpenCV, ROS and BoofCV files, distinguished by the names in the files."""

import re
from functools import partial

import numpy as np

from ncdc_model.calibration.files.camera_info import rectified, windowed
from ncdc_model.calibration.files.distortion import fisheye, perspective, unified_sphere
from ncdc_model.calibration.files.lens import (
    UNBENT,
    choose,
    coefficients,
    file_lens,
    flag,
    numbers,
    whole,
)
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["camera_matrix", "first", "is_opencv", "opencv_lens", "opencv_model", "size_of"]

_MATRIX = ("camera_matrix", "cameraMatrix", "Camera_Matrix", "intrinsic_matrix", "mtx", "K", "k")
_COEFFICIENTS = ("distortion_coefficients", "Distortion_Coefficients", "distCoeffs", "dist_coeffs",
                 "dist_coeff", "dist", "D", "d")
_MODEL = ("distortion_model", "camera_model", "model")
_SIZE = {"width": ("image_width", "image_Width", "imageWidth", "width"),
         "height": ("image_height", "image_Height", "imageHeight", "height")}
_BOTH = ("image_size", "imageSize", "img_size", "resolution")
_OTHERS = ("xi", "fisheye_model", "rectification_matrix", "projection_matrix", "R", "P", "header",
           "binning_x", "binning_y", "roi")
_MOST = 64             # radial coefficients of BoofCV
_FULL = 4, 5, 8, 12, 14
_PERSPECTIVE = {"plumb_bob": (4, 5), "rational_polynomial": (4, 5, 8), "thin_prism": _FULL[:4],
                "pinhole": _FULL, "opencv": _FULL, "brown": _FULL, "brown_conrady": _FULL,
                "radtan": (4, 5), "none": (4,)}
_FISHEYE = ("fisheye", "equidistant", "kannala_brandt", "opencv_fisheye")
# Of a stereo file: M1 and D1, camera_matrix_left and dist_coeffs_left ...
_SIDE = re.compile(r"(M|K|mtx|camera_?matrix|intrinsic_matrix|D|dist|dist_?coeffs?|"
                   r"distortion_coefficients|R|P|rectification_matrix|projection_matrix)"
                   r"_?(1|2|l|r|left|right)", re.IGNORECASE)
_PLAIN = {"k": "K", "d": "D", "r": "rectification_matrix", "p": "projection_matrix",
          "dist": "dist", "rectification_matrix": "rectification_matrix",
          "projection_matrix": "projection_matrix"}


def is_opencv(table):
    """Whether ``table`` holds the matrix of a camera, or those of a pair."""
    return any(name in table for name in _MATRIX) or bool(_sides(table))


def opencv_lens(table, camera=None):
    """:class:`FileLens` of the names and values of an OpenCV, ROS or BoofCV file.

    Models: OpenCV's perspective one with 4, 5, 8, 12 or 14 coefficients (k1 k2 p1 p2 k3 k4 k5
    k6 s1 s2 s3 s4 tx ty; ROS's plumb_bob and rational_polynomial), OpenCV's fisheye with 4 (ROS's
    equidistant), its omnidirectional one with xi, and BoofCV's omnidirectional_universal. The
    value distortion_model, camera_model or model chooses one. Without it 4 coefficients named D
    with a matrix named K are a fisheye's, as in OpenCV's documentation, and others are
    perspective. Rectification, projection, binning and region of interest:
    :mod:`ncdc_model.calibration.files.camera_info`. ``camera`` is 1, 2, left or right for a stereo
    pair, or the name of one of several tables.

    Raises
    ------
    InputError
        If a value is not finite or out of range, the model is unknown, or ``camera`` is given for
        a file of one camera.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    name = re.sub(r"[\s-]+", "_", str(first(table, _MODEL, "")).strip().lower())
    if name == "omnidirectional_universal":
        _unnamed(camera)
        return _omnidirectional(table)
    inner = {key: value for key, value in table.items()
             if isinstance(value, dict) and is_opencv(value)}
    if inner and not is_opencv(table):
        check_read(table, inner)
        return opencv_lens(inner[choose(inner, camera)])
    sides = {} if any(key in table for key in _MATRIX) else _sides(table)
    if sides:
        chosen = choose(sides, camera)
        table = {key: value for key, value in table.items() if _side(key) not in sides}
        table |= sides[chosen]
    else:
        _unnamed(camera)
    if not any(key in table for names in (_MATRIX, _COEFFICIENTS, *_SIZE.values())
               for key in names):
        names = ", ".join(map(str, list(table)[:8])) or "none"
        raise InputError(f"it is none of the camera files that are known: its names are {names}")
    # Open3D writes intrinsic_matrix column by column.
    matrix, warnings = camera_matrix(first(table, _MATRIX), "intrinsic_matrix" in table,
                                     "xi" in table), []
    values = first(table, _COEFFICIENTS, None)
    if values is None and name != "none":
        warnings.append(UNBENT)
    used = [next((key for key in names if table.get(key) is not None), None)
            for names in (_MATRIX, _COEFFICIENTS)]
    check_read(table, {*used, *_MODEL, *_SIZE["width"], *_SIZE["height"], *_BOTH, *_OTHERS},
               bent=name == "none" or "xi" in table or values is not None and (
                   numbers(values, "list of distortion coefficients").any()))
    model, distortion = opencv_model(table, name, values)
    lens = file_lens(size_of(table), matrix, distortion, model, warnings=tuple(warnings))
    return windowed(rectified(lens, table), table)


def opencv_model(table, name, values):
    """Name for reports and distortion of the model ``name`` with the coefficients ``values``."""
    wide = name in _FISHEYE or flag(table.get("fisheye_model"), "fisheye_model")
    if not name and "K" in table and "D" in table:
        wide = wide or numbers(values, "distortion coefficients").size == 4
    if "xi" in table:
        xi, = numbers(table["xi"], "value xi", (1,))
        k = coefficients(values, "omnidirectional", (4,))
        return "omnidirectional", partial(unified_sphere, offset=xi, radial=k[:2],
                                          tangential=k[2:])
    if wide:
        return "fisheye", partial(fisheye, coefficients=coefficients(values, "fisheye", (4,)))
    if name and name not in _PERSPECTIVE:
        known = ", ".join([*_PERSPECTIVE, *_FISHEYE, "omnidirectional_universal"])
        raise InputError(f"the distortion model is {name!r}, one of {known} is needed")
    k = coefficients(values, name or "opencv", _PERSPECTIVE[name or "opencv"])
    return f"perspective with {len(k)} coefficients", partial(perspective, coefficients=k)


def size_of(table):
    """Width and height of the distorted image, or None if the file holds neither."""
    if any(first(table, names, None) is not None for names in _SIZE.values()):
        return tuple(whole(first(table, names), side) for side, names in _SIZE.items())
    for name in _BOTH:
        if table.get(name) is not None:
            width, height = numbers(table[name], name, (2,))
            return whole(width, "width"), whole(height, "height")
    return None


def camera_matrix(values, by_column=False, skewed=False):
    """Matrix (3, 3) of nine numbers, ``by_column`` if they may be; :class:`InputError` if it is no
    [[fx, 0, cx], [0, fy, cy], [0, 0, 1]], or of a skew that is not ``skewed``."""
    matrix = numbers(values, "camera matrix", (9,)).reshape(3, 3)
    if by_column and (matrix[:, 2] == (0, 0, 1)).all():
        matrix = matrix.T
    if (matrix[2] != (0, 0, 1)).any() or matrix[1, 0]:
        raise InputError(f"the camera matrix is {matrix.tolist()}, [[fx, 0, cx], [0, fy, cy], "
                         f"[0, 0, 1]] is needed")
    if matrix[0, 1] and not skewed:
        raise InputError(f"the camera matrix has the skew {matrix[0, 1]:g}, which OpenCV's models "
                         f"do not have")
    return matrix


def _sides(table):
    """Tables of the cameras of a stereo file, by their names: 1 and 2, left and right.

    A single number, such as the coefficient k1, is no matrix of a camera.
    """
    sides = {}
    for key, value in table.items():
        if np.ndim(value.get("data", 0) if isinstance(value, dict) else value) and (
                side := _side(key)):
            kind = _SIDE.fullmatch(key)[1].lower()
            plain = _PLAIN.get(kind, "dist" if kind.startswith("d") else "mtx")
            sides.setdefault(side, {})[plain] = value
    return {side: part for side, part in sides.items() if {"K", "mtx"} & part.keys()}


def _side(key):
    """1, 2, left or right, if the name is that of a value of one of two cameras."""
    found = _SIDE.fullmatch(str(key))
    return found and {"l": "left", "r": "right"}.get(found[2].lower(), found[2].lower())


def _omnidirectional(table):
    pinhole, bends = table["pinhole"], table["radial_tangential"]
    size = whole(pinhole["width"], "width"), whole(pinhole["height"], "height")
    fx, fy, cx, cy, skew, t1, t2, offset = numbers(
        [pinhole["fx"], pinhole["fy"], pinhole["cx"], pinhole["cy"], pinhole.get("skew", 0.0),
         bends.get("t1", 0.0), bends.get("t2", 0.0), table["mirror_offset"]], "camera", (8,))
    radial = numbers(bends.get("radial") or [0.0], "radial coefficients")
    if len(radial) > _MOST:
        raise InputError(f"radial holds {len(radial)} coefficients, the limit is {_MOST}")
    check_read(table, ("pinhole", "radial_tangential", "mirror_offset", *_MODEL))
    check_read({**pinhole, **bends}, ("width", "height", "fx", "fy", "cx", "cy", "skew", "radial",
                                      "t1", "t2"))
    return file_lens(size, np.array([[fx, skew, cx], [0, fy, cy], [0, 0, 1]]),
                     lambda a, b: unified_sphere(a, b, offset, radial, (t1, t2)),
                     "omnidirectional_universal")


def _unnamed(camera):
    if camera is not None:
        raise InputError(f"camera {camera} is asked for, the file holds one camera without a name")


_REQUIRED = object()


def first(table, names, default=_REQUIRED):
    """The first value of ``names`` that ``table`` has."""
    for name in names:
        if name in table and table[name] is not None:
            return table[name]
    if default is _REQUIRED:
        raise KeyError(" or ".join(names))
    return default
