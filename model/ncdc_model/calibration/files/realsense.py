"""Intrinsics of librealsense, written as JSON or printed by ``rs-enumerate-devices -c``."""

import re
from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import (
    field_of_view,
    fisheye,
    modified_brown,
    perspective,
)
from ncdc_model.calibration.files.lens import choose, file_lens, matrix_of, numbers, whole
from ncdc_model.calibration.files.opencv import first
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_realsense", "printed_cameras", "realsense_lens"]

_MODELS = ("none", "modified_brown_conrady", "inverse_brown_conrady", "ftheta", "brown_conrady",
           "kannala_brandt4")
_MODEL = "model", "distortion_model", "distortion"
_COEFFICIENTS = "coeffs", "coefficients", "distortion_coeffs"
_BLOCK = re.compile(r"Intrinsic of \"(?P<name>[^\"]+)\"\s*/?\s*(?P<size>\d+x\d+)[^\n]*\n"
                    r"(?P<values>(?:[^\S\n]*[A-Za-z][^\n:]*:[^\n]*\n?)+)")


def is_realsense(table):
    """Whether the names and values are those of one or of several intrinsics."""
    return bool(_cameras(table))


def _cameras(table, name=""):
    if "ppx" in table and "ppy" in table:
        return {name: table}
    found = {}
    for key, value in table.items():
        if isinstance(value, dict):
            found |= _cameras(value, f"{name}.{key}" if name else str(key))
    return found


def printed_cameras(text):
    """Table of the intrinsics that ``rs-enumerate-devices -c`` prints, by stream and size."""
    table = {}
    for found in _BLOCK.finditer(text):
        values = dict(line.split(":", 1) for line in found["values"].splitlines() if ":" in line)
        values = {name.strip().lower(): value.strip() for name, value in values.items()}
        if {"ppx", "ppy", "fx", "fy", "width", "height"} <= values.keys():
            values["coeffs"] = values.get("coeffs", "").split()
            values["model"] = values.get("distortion", "")
            table.setdefault(f"{found['name']} {found['size']}", values)
    return table


def realsense_lens(table, camera=None):
    """:class:`FileLens` of the intrinsics; ``camera`` chooses one of several streams.

    The inverse Brown-Conrady model is read without coefficients only. By its description they
    correct a distorted point; in librealsense's code since 2.36 they distort an ideal one.

    Raises
    ------
    InputError
        If the camera is not chosen or absent, or the model unknown or inverse with coefficients.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    cameras = _cameras(table)
    if camera is not None and list(cameras) == [""]:
        raise InputError(f"camera {camera} is asked for, the file holds one camera without a name")
    chosen = cameras[choose(cameras, camera)]
    model = first(chosen, _MODEL)
    name = re.sub(r"^(rs2?_distortion_|distortion\.)", "", str(model).strip().lower())
    name = re.sub(r"[\s\-]+", "_", name)
    name = _MODELS[int(name)] if name.isdecimal() and int(name) < len(_MODELS) else name
    if name not in _MODELS:
        raise InputError(f"the distortion model is {model!r}, one of {', '.join(_MODELS)} is "
                         f"needed")
    k = numbers(first(chosen, _COEFFICIENTS), "list of coefficients", (5,))
    used = next(key for key in _COEFFICIENTS if chosen.get(key) is not None)
    check_read(chosen, (used, *(key for key in _MODEL if np.isscalar(chosen.get(key)))))
    if name == "inverse_brown_conrady" and k.any():
        raise InputError("the model inverse_brown_conrady with coefficients is not supported, as "
                         "versions of librealsense differ in what they mean; calibrate the camera "
                         "as brown_conrady, or make a map")
    if name == "none" and k.any():
        raise InputError(f"the distortion model is none, with coefficients that are not 0; one of "
                         f"{', '.join(_MODELS[1:])} uses them")
    distortion = {"brown_conrady": partial(perspective, coefficients=k),
            "modified_brown_conrady": partial(modified_brown, coefficients=k),
            "kannala_brandt4": partial(fisheye, coefficients=k[:4]),
            "ftheta": lambda a, b: field_of_view(a, b, k[0])}.get(name, lambda a, b: (a, b))
    return file_lens((whole(chosen["width"], "width"), whole(chosen["height"], "height")),
                     matrix_of(*(chosen[key] for key in ("fx", "fy", "ppx", "ppy"))), distortion,
                     f"RealSense {name}")
