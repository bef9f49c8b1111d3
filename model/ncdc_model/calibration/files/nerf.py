"""transforms.json of instant-ngp and nerfstudio."""

from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import fisheye, unified_sphere
from ncdc_model.calibration.files.lens import choose, file_lens, matrix_of, numbers, whole
from ncdc_spec.errors import InputError

__all__ = ["is_nerf", "nerf_lens"]

_FOCAL = "fl_x", "camera_angle_x"
_OWN = ("fl_x", "fl_y", "cx", "cy", "w", "h", "k1", "k2", "k3", "k4", "p1", "p2",
        "camera_angle_x", "camera_angle_y", "camera_model")
_PERSPECTIVE = ("", "OPENCV", "PINHOLE", "SIMPLE_PINHOLE", "SIMPLE_RADIAL", "RADIAL",
                "PERSPECTIVE")
_CORNER = 0.5          # pixels count from the corner of the first one, in NCDC from its centre


def is_nerf(table):
    """Whether the names and values are those of a transforms.json."""
    frames = table.get("frames")
    return any(name in table for name in _FOCAL) or (
        isinstance(frames, list) and bool(frames) and isinstance(frames[0], dict)
        and "transform_matrix" in frames[0])


def nerf_lens(table, camera=None):
    """:class:`FileLens` of the file's camera; if each frame has its own, ``camera`` is the
    file_path of one.

    Models: OPENCV (k1 to k4 of the radius, p1, p2) and OPENCV_FISHEYE.

    Raises
    ------
    InputError
        If the camera is not chosen, or the model unknown.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    frames = {str(frame.get("file_path", k)): {**table, **frame}
              for k, frame in enumerate(table.get("frames") or ())}
    if any(name in frame for frame in table.get("frames") or () for name in _OWN):
        own = [[frame.get(name) for name in _OWN] for frame in frames.values()]
        if all(values == own[0] for values in own) and camera is None:
            camera = next(iter(frames))
        table = frames[choose(frames, camera, "frames")]
    elif camera is not None:
        raise InputError(f"camera {camera} is asked for, the file holds one camera without a name")
    size = None
    if "w" in table or "h" in table or "fl_x" not in table:
        size = width, height = whole(table["w"], "width"), whole(table["h"], "height")
    fx = table["fl_x"] if "fl_x" in table else _focal(width, table["camera_angle_x"])
    fy = table["fl_y"] if "fl_y" in table else (
        _focal(height, table["camera_angle_y"]) if "camera_angle_y" in table else fx)
    k = {name: float(table.get(name) or 0) for name in ("k1", "k2", "k3", "k4", "p1", "p2")}
    radial = numbers([k["k1"], k["k2"], k["k3"], k["k4"]], "list of distortion coefficients")
    tangential = numbers([k["p1"], k["p2"]], "list of distortion coefficients")
    model = str(table.get("camera_model") or "").upper()
    if table.get("is_fisheye") or model == "OPENCV_FISHEYE":
        if tangential.any():
            raise InputError("p1 and p2 are given, which the model OPENCV_FISHEYE does not have")
        model, distortion = "OPENCV_FISHEYE", partial(fisheye, coefficients=radial)
    elif model in _PERSPECTIVE:
        distortion = partial(unified_sphere, offset=0.0, radial=radial, tangential=tangential)
    else:
        raise InputError(f"the camera model is {model}, OPENCV or OPENCV_FISHEYE is needed")
    cx, cy = (table[name] if size is None else table.get(name, side / 2)
              for name, side in zip(("cx", "cy"), size or (0, 0)))
    return file_lens(size, matrix_of(fx, fy, float(cx) - _CORNER, float(cy) - _CORNER), distortion,
                     f"NeRF {model or 'OPENCV'}")


def _focal(side, angle):
    return side / 2 / np.tan(float(angle) / 2)
