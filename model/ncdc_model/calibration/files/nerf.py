"""transforms.json of instant-ngp and nerfstudio."""

from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import fisheye, unified_sphere
from ncdc_model.calibration.files.lens import (
    UNBENT,
    choose,
    file_lens,
    flag,
    matrix_of,
    numbers,
    single,
    whole,
)
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_nerf", "nerf_lens"]

_FOCAL = "fl_x", "camera_angle_x"
_RADIAL, _TANGENTIAL = ("k1", "k2", "k3", "k4"), ("p1", "p2")
_OWN = ("fl_x", "fl_y", "cx", "cy", "w", "h", *_RADIAL, *_TANGENTIAL, "camera_angle_x",
        "camera_angle_y", "camera_model", "is_fisheye")
_PINHOLE = "PINHOLE", "SIMPLE_PINHOLE"
_PERSPECTIVE = ("", "OPENCV", *_PINHOLE, "SIMPLE_RADIAL", "RADIAL", "PERSPECTIVE")
_CORNER = 0.5          # pixels count from the corner of the first one, in NCDC from its centre


def is_nerf(table):
    """Whether the names and values are those of a transforms.json."""
    frames = table.get("frames")
    return any(name in table for name in _FOCAL) or (
        isinstance(frames, list) and bool(frames) and isinstance(frames[0], dict)
        and any(name in frames[0] for name in (*_FOCAL, "transform_matrix")))


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
    check_read({name: value for frame in table.get("frames") or () for name, value in frame.items()
                if value}, _OWN)
    frames = {str(frame.get("file_path", k)): {**table, **frame}
              for k, frame in enumerate(table.get("frames") or ())}
    if any(name in frame for frame in table.get("frames") or () for name in _OWN):
        own = [[frame.get(name) for name in _OWN] for frame in frames.values()]
        bent = any(name in frame for frame in table["frames"] for name in _RADIAL + _TANGENTIAL)
        if bent and camera is None:
            raise InputError(f"it is a transforms.json of NeRF programs whose frames have each a "
                             f"lens of their own, with {_RADIAL[0]} and others; --camera "
                             f"{next(iter(frames))} takes that of one frame")
        if all(values == own[0] for values in own) and camera is None:
            camera = next(iter(frames))
        table = frames[choose(frames, camera, "frames")]
    elif camera is not None:
        raise InputError(f"camera {camera} is asked for, the file holds one camera without a name")
    if not {"w", "h", "fl_x"} & table.keys():
        raise InputError("it is a transforms.json of Blender, as NeRF's synthetic scenes have it: "
                         "its camera has an angle, no size and no distortion, so there is nothing "
                         "to correct")
    model = str(table.get("camera_model") or "").upper()
    wide = flag(table.get("is_fisheye"), "is_fisheye") or model == "OPENCV_FISHEYE"
    bent = any(table.get(name) is not None for name in _RADIAL + _TANGENTIAL)
    check_read(table, (*_OWN, "frames"), bent or wide or model in _PINHOLE)
    size = None
    if "w" in table or "h" in table or "fl_x" not in table:
        size = width, height = whole(table["w"], "width"), whole(table["h"], "height")
    fx = table["fl_x"] if "fl_x" in table else _focal(width, table["camera_angle_x"])
    fy = table["fl_y"] if "fl_y" in table else (
        _focal(height, table["camera_angle_y"]) if "camera_angle_y" in table else fx)
    radial, tangential = (numbers([_number(table, name) for name in names],
                                  "list of distortion coefficients")
                          for names in (_RADIAL, _TANGENTIAL))
    if wide:
        if tangential.any():
            raise InputError("p1 and p2 are given, which the model OPENCV_FISHEYE does not have")
        model, distortion = "OPENCV_FISHEYE", partial(fisheye, coefficients=radial)
    elif model in _PERSPECTIVE:
        distortion = partial(unified_sphere, offset=0.0, radial=radial, tangential=tangential)
    else:
        raise InputError(f"the camera model is {model}, OPENCV or OPENCV_FISHEYE is needed")
    cx, cy = (table[name] if size is None else table.get(name, side / 2)
              for name, side in zip(("cx", "cy"), size or (0, 0)))
    matrix = matrix_of(fx, fy, single(cx, "cx") - _CORNER, single(cy, "cy") - _CORNER)
    return file_lens(size, matrix, distortion,
                     f"NeRF {model or 'OPENCV'}", warnings=() if bent else (UNBENT,))


def _number(table, name):
    """The coefficient ``name``, 0 if it is absent or null."""
    return 0.0 if table.get(name) is None else single(table[name], name)


def _focal(side, angle):
    return side / 2 / np.tan(single(angle, "camera angle") / 2)
