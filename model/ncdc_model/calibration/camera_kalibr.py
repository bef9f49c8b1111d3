"""Cameras of a camchain file of Kalibr."""

import numpy as np

from ncdc_model.calibration.file_lens import fisheye, numbers, perspective, unified_sphere, whole
from ncdc_model.errors import InputError

__all__ = ["is_camchain", "kalibr_lens"]

# Names of the intrinsics before the focal lengths and the principal point, by projection.
_INTRINSICS = {"pinhole": (), "omni": ("xi",), "eucm": ("alpha", "beta"), "ds": ("xi", "alpha")}
_COEFFICIENTS = {"radtan": 4, "equidistant": 4, "fov": 1, "none": 0}
_LONG = {"equi": "equidistant"}
_DISTORTIONS = {"pinhole": tuple(_COEFFICIENTS), "omni": ("radtan", "none"), "eucm": ("none",),
                "ds": ("none",)}


def is_camchain(table):
    """Whether the names and values are those of a camchain."""
    return isinstance(table.get("cam0"), dict)


def kalibr_lens(table, camera=None):
    """Size, matrix, bend and model, for :func:`~ncdc_model.calibration.file_lens.file_lens`.

    Projections and distortions: pinhole with radtan, equidistant, fov or none; omni (the unified
    model) with radtan or none; eucm and ds (double sphere) with none.

    Parameters
    ----------
    table : dict
        The whole file: cam0, cam1 ...
    camera : str, optional
        Which one; may be left out where there is one only.

    Raises
    ------
    InputError
        If the choice is open or absent, the model is none of the above or has another number of
        values.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    names = [name for name in table if str(name).startswith("cam")]
    if camera is None and len(names) > 1:
        raise InputError(f"the file holds the cameras {', '.join(names)}, one must be chosen")
    camera = camera or names[0]
    if camera not in names:
        raise InputError(f"camera {camera} is asked for, the file holds {', '.join(names)}")
    entry = table[camera]
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
    fx, fy, cx, cy = values[own:]
    k = numbers(entry.get("distortion_coeffs") or [], "list of distortion coefficients",
                (_COEFFICIENTS[distortion],))
    return ((whole(width, "width"), whole(height, "height")),
            np.array([[fx, 0, cx], [0, fy, cy], [0, 0, 1]]),
            _bend(projection, values[:own], distortion, k),
            f"{camera} {projection} {distortion}" if distortion != "none" else
            f"{camera} {projection}")


def _bend(projection, own, distortion, k):
    """Distorted point of an ideal one, in units of the focal length."""
    if projection == "omni":
        offset, = own
        k1, k2, p1, p2 = k if len(k) else np.zeros(4)
        return lambda a, b: unified_sphere(a, b, offset, (k1, k2), (p1, p2))
    if projection in ("ds", "eucm"):
        depth = (_double_sphere if projection == "ds" else _extended_unified)
        return lambda a, b: (a / depth(a * a + b * b, *own), b / depth(a * a + b * b, *own))
    return {"radtan": lambda a, b: perspective(a, b, k),
            "equidistant": lambda a, b: fisheye(a, b, k),
            "fov": lambda a, b: _field_of_view(a, b, *k),
            "none": lambda a, b: (a, b)}[distortion]


def _double_sphere(q, xi, alpha):
    """Depth by which the ideal point of squared radius ``q`` is divided.

    Of Usenko, Demmel and Cremers.
    """
    near = np.sqrt(q + 1)
    shifted = xi * near + 1
    return alpha * np.sqrt(q + shifted * shifted) + (1 - alpha) * shifted


def _extended_unified(q, alpha, beta):
    """Depth of the extended unified model of Khomutenko, Garcia and Martinet."""
    return alpha * np.sqrt(beta * q + 1) + 1 - alpha


def _field_of_view(a, b, w):
    """Devernay and Faugeras: distorted radius atan(2 r tan(w / 2)) / w."""
    if not 0 < w < np.pi:
        raise InputError(f"the field of view is {w:g} rad, it must lie between 0 and pi")
    r = np.hypot(a, b)
    scale = np.where(r > 0, np.arctan(2 * r * np.tan(w / 2)) / (w * np.where(r > 0, r, 1)),
                     2 * np.tan(w / 2) / w)
    return a * scale, b * scale
