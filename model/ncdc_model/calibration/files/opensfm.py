"""Cameras of OpenSfM and OpenDroneMap: camera_models.json, cameras.json, reconstruction.json."""

from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import fisheye, perspective
from ncdc_model.calibration.files.lens import UNBENT, choose, file_lens, matrix_of, numbers, whole
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_opensfm", "opensfm_lens"]

_ONE, _TWO = ("focal", "focal"), ("focal_x", "focal_y")
# Distortion, names of the focal lengths and of the coefficients in OpenCV's order.
_MODELS = {"perspective": (perspective, _ONE, ("k1", "k2")),
           "simple_radial": (perspective, _TWO, ("k1",)),
           "radial": (perspective, _TWO, ("k1", "k2")),
           "brown": (perspective, _TWO, ("k1", "k2", "p1", "p2", "k3")),
           "fisheye": (fisheye, _ONE, ("k1", "k2")),
           "fisheye_opencv": (fisheye, _TWO, ("k1", "k2", "k3", "k4"))}


def is_opensfm(table):
    """Whether the names and values are those of cameras of OpenSfM, or of reconstructions."""
    return bool(_cameras(table))


def _cameras(table):
    found = {}
    for name, value in table.items():
        if isinstance(value, dict):
            if "projection_type" in value:
                found[str(name)] = value
            elif isinstance(value.get("cameras"), dict):
                # Of a list of reconstructions, whose places are their names.
                found |= {f"{name} {key}" if len(table) > 1 else key: camera
                          for key, camera in _cameras(value["cameras"]).items()}
    return found


def opensfm_lens(table, camera=None):
    """:class:`FileLens` of one camera; lengths in the file are parts of the larger side.

    Raises
    ------
    InputError
        If the camera is not chosen or absent, or its model is another.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    cameras = _cameras(table)
    camera = choose(cameras, camera)
    entry = cameras[camera]
    model = str(entry["projection_type"]).lower()
    if model not in _MODELS:
        raise InputError(f"it is a camera file of OpenSfM, whose camera {camera} has the model "
                         f"{model}; one of {', '.join(_MODELS)} is needed")
    distortion, focal, names = _MODELS[model]
    bent = any(name in entry for name in names)
    check_read(entry, (*focal, *names, "projection_type", "c_x", "c_y"),
               bent or distortion is fisheye)
    size = width, height = whole(entry["width"], "width"), whole(entry["height"], "height")
    own = numbers([*(entry[name] for name in focal), entry.get("c_x", 0), entry.get("c_y", 0)],
                  "list of focal lengths and centre", (4,)) * max(size)
    k = numbers([entry.get(name, 0) for name in names], "list of distortion coefficients")
    k = np.pad(k, (0, max(0, 4 - len(k))))
    matrix = matrix_of(own[0], own[1], own[2] + (width - 1) / 2, own[3] + (height - 1) / 2)
    return file_lens(size, matrix, partial(distortion, coefficients=k), f"OpenSfM {model}",
                     warnings=() if bent else (UNBENT,))
