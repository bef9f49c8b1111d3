"""Cameras of COLMAP: cameras.txt and cameras.bin."""

import re
import struct
from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import (
    field_of_view,
    fisheye,
    on_angle,
    perspective,
    unified_sphere,
)
from ncdc_model.calibration.files.lens import choose, file_lens, matrix_of, numbers, whole
from ncdc_spec.errors import InputError

__all__ = ["binary_lens", "is_colmap", "text_lens"]

# COLMAP's number of each model, its count of focal lengths and its count of coefficients.
_MODELS = {"SIMPLE_PINHOLE": (0, 1, 0), "PINHOLE": (1, 2, 0), "SIMPLE_RADIAL": (2, 1, 1),
           "RADIAL": (3, 1, 2), "OPENCV": (4, 2, 4), "OPENCV_FISHEYE": (5, 2, 4),
           "FULL_OPENCV": (6, 2, 8), "FOV": (7, 2, 1), "SIMPLE_RADIAL_FISHEYE": (8, 1, 1),
           "RADIAL_FISHEYE": (9, 1, 2), "THIN_PRISM_FISHEYE": (10, 2, 8),
           "SIMPLE_FISHEYE": (14, 1, 0), "FISHEYE": (15, 2, 0)}
# Known, not supported; their sizes give the position of the next camera in cameras.bin.
_OTHERS = {"RAD_TAN_THIN_PRISM_FISHEYE": (11, 16), "SIMPLE_DIVISION": (12, 4),
           "DIVISION": (13, 5), "EUCM": (16, 6), "EQUIRECTANGULAR": (17, 2)}
_LINE = re.compile(r"\d+ +[A-Z][A-Z_]+ +\d+ +\d+( +\S+)+")
_CORNER = 0.5          # COLMAP counts from the corner of the first pixel, NCDC from its centre


def is_colmap(text):
    """Whether ``text`` is a cameras.txt."""
    lines = _lines(text)
    return bool(lines) and all(_LINE.fullmatch(line) for line in lines)


def _lines(text):
    lines = (" ".join(line.split()) for line in text.splitlines())
    return [line for line in lines if line and not line.startswith("#")]


def text_lens(text, camera=None):
    """:class:`FileLens` of a cameras.txt; ``camera`` is an id.

    Raises
    ------
    InputError
        If the camera is not chosen or absent, or the model unknown or of another length.
    """
    cameras = {}
    for line in _lines(text):
        number, model, width, height, *values = line.split()
        cameras[number] = model, width, height, values
    return _lens(cameras, camera)


def binary_lens(content, camera=None):
    """:class:`FileLens` of a cameras.bin; as :func:`text_lens`."""
    names = {number: (name, sum(sizes) + 2) for name, (number, *sizes) in _MODELS.items()}
    names |= {number: (name, size) for name, (number, size) in _OTHERS.items()}
    cameras = {}
    try:
        count, = struct.unpack_from("<Q", content)
        at = 8
        for _ in range(count):
            number, model, width, height = struct.unpack_from("<IiQQ", content, at)
            name, size = names[model]
            cameras[str(number)] = (name, width, height,
                                    struct.unpack_from(f"<{size}d", content, at + 24))
            at += 24 + 8 * size
    except (struct.error, KeyError) as error:
        raise InputError("it is no cameras.bin of COLMAP") from error
    if at != len(content) or not cameras:
        raise InputError("it is no cameras.bin of COLMAP")
    return _lens(cameras, camera)


def _lens(cameras, camera):
    number = choose(cameras, camera)
    model, width, height, values = cameras[number]
    if model not in _MODELS:
        raise InputError(f"camera {number} has the model {model}, one of {', '.join(_MODELS)} is "
                         f"needed")
    _, focals, own = _MODELS[model]
    values = numbers(values, f"camera {number} of the model {model}", (focals + 2 + own,))
    fx, fy, cx, cy = *values[[0, focals - 1]], *values[focals:focals + 2]
    return file_lens((whole(width, "width"), whole(height, "height")),
                     matrix_of(fx, fy, cx - _CORNER, cy - _CORNER),
                     _distortion(model, values[focals + 2:]), f"COLMAP {model}")


def _distortion(model, k):
    if model == "FOV":
        return lambda a, b: field_of_view(a, b, k[0])
    if model == "OPENCV_FISHEYE":
        return partial(fisheye, coefficients=k)
    if model == "THIN_PRISM_FISHEYE":
        return partial(on_angle, radial=k[[0, 1, 4, 5]], tangential=k[2:4], prism=k[6:])
    if model.endswith("FISHEYE"):
        return partial(on_angle, radial=k)
    if model.endswith("OPENCV"):
        return partial(perspective, coefficients=np.asarray(k))
    return partial(unified_sphere, offset=0.0, radial=k)
