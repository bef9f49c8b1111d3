"""Cameras of a camchain file of Kalibr, and of a sensor.yaml of the EuRoC data sets."""

from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import (
    field_of_view,
    fisheye,
    perspective,
    unified_sphere,
)
from ncdc_model.calibration.files.lens import (
    choose,
    coefficients,
    file_lens,
    matrix_of,
    numbers,
    whole,
)
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_camchain", "kalibr_lens"]

# Names of the intrinsics before the focal lengths and the principal point, by projection.
_INTRINSICS = {"pinhole": (), "omni": ("xi",), "eucm": ("alpha", "beta"), "ds": ("xi", "alpha")}
_COEFFICIENTS = {"radtan": 4, "equidistant": 4, "fov": 1, "none": 0}
_NAMES = "distortion_coeffs", "distortion_coefficients"
_LONG = {"equi": "equidistant", "radial-tangential": "radtan"}
_DISTORTIONS = {"pinhole": tuple(_COEFFICIENTS), "omni": ("radtan", "none"), "eucm": ("none",),
                "ds": ("none",)}


def is_camchain(table):
    """Whether the names and values are those of a camchain, or of one camera of it."""
    return bool(_cameras(table)) or {"intrinsics", "resolution"} <= table.keys()


def _cameras(table):
    return [name for name, value in table.items()
            if str(name).startswith("cam") and isinstance(value, dict)
            and {"intrinsics", "camera_model"} & value.keys()]


def kalibr_lens(table, camera=None):
    """:class:`FileLens` of a camchain.

    Projections and distortions: pinhole with radtan, equidistant, fov or none; omni (the unified
    model) with radtan or none; eucm and ds (double sphere) with none.

    Parameters
    ----------
    table : dict
        The whole file: cam0, cam1 ..., or one camera without a name.
    camera : str, optional
        Name of one; not needed if there is only one.

    Raises
    ------
    InputError
        If the camera is not chosen or absent, the model is not supported or has another number of
        values.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    names = _cameras(table) or ["cam0"]
    camera = choose(names, camera)
    entry = table[camera] if camera in table else table
    projection = str(entry["camera_model"]).lower()
    distortion = str(entry["distortion_model"]).lower()
    distortion = _LONG.get(distortion, distortion)
    if projection not in _INTRINSICS:
        raise InputError(f"{camera} has the model {projection!r}, one of "
                         f"{', '.join(_INTRINSICS)} is needed")
    if distortion not in _DISTORTIONS[projection]:
        raise InputError(f"{camera} has the distortion {distortion!r}, with {projection} one of "
                         f"{', '.join(_DISTORTIONS[projection])} is needed")
    width, height = entry["resolution"]
    own = len(_INTRINSICS[projection])
    values = numbers(entry["intrinsics"], "list of intrinsics", (own + 4,))
    name = next((name for name in _NAMES if name in entry), None)
    if name is None and distortion != "none":
        raise KeyError(_NAMES[0])
    check_read(entry, (name, "camera_model", "intrinsics", "distortion_model", "resolution"))
    k = coefficients(entry.get(name), f"{camera} {distortion}", (_COEFFICIENTS[distortion],))
    model = f"{camera} {projection} {distortion}".removesuffix(" none")
    return file_lens((whole(width, "width"), whole(height, "height")), matrix_of(*values[own:]),
                     _distortion(projection, values[:own], distortion, k), model)


def _distortion(projection, own, distortion, k):
    """Distorted point of an ideal one, in units of the focal length."""
    if projection == "omni":
        k = k if len(k) else np.zeros(4)
        return partial(unified_sphere, offset=own[0], radial=k[:2], tangential=k[2:])
    if projection in ("ds", "eucm"):
        depth = (_double_sphere if projection == "ds" else _extended_unified)
        return lambda a, b: (a / depth(a * a + b * b, *own), b / depth(a * a + b * b, *own))
    return {"radtan": partial(perspective, coefficients=k),
            "equidistant": partial(fisheye, coefficients=k),
            "fov": lambda a, b: field_of_view(a, b, *k),
            "none": lambda a, b: (a, b)}[distortion]


def _double_sphere(q, xi, alpha):
    """Depth by which the ideal point of squared radius ``q`` is divided.

    The model is that of Usenko, Demmel and Cremers.
    """
    near = np.sqrt(q + 1)
    shifted = xi * near + 1
    return alpha * np.sqrt(q + shifted * shifted) + (1 - alpha) * shifted


def _extended_unified(q, alpha, beta):
    """Depth of the extended unified model of Khomutenko, Garcia and Martinet."""
    return alpha * np.sqrt(beta * q + 1) + 1 - alpha
