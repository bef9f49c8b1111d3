"""Settings of stella_vslam and OpenVSLAM: a camera named Camera, or names that begin with it."""

from functools import partial

from ncdc_model.calibration.files.distortion import division, fisheye, perspective
from ncdc_model.calibration.files.lens import file_lens, matrix_of, numbers, whole
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_stella", "stella_lens"]

_MODELS = {"perspective": (perspective, ("k1", "k2", "p1", "p2", "k3")),
           "fisheye": (fisheye, ("k1", "k2", "k3", "k4")),
           "radial_division": (division, ("distortion",))}


def is_stella(table):
    """Whether the names and values are those of a camera of stella_vslam."""
    return {"model", "fx", "cols"} <= _camera(table).keys()


def _camera(table):
    if isinstance(table.get("Camera"), dict):
        return table["Camera"]
    return {name.removeprefix("Camera."): value for name, value in table.items()
            if str(name).startswith("Camera.")}


def stella_lens(table):
    """:class:`FileLens` of the models perspective, fisheye and radial_division.

    Raises
    ------
    InputError
        If the model is another, or the camera is that of rectified pictures.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    if any(str(name).partition(".")[0] == "StereoRectifier" for name in table):
        raise InputError("it is a stella_vslam file with a StereoRectifier, whose Camera is that "
                         "of rectified pictures; write K, D and size of one side as an OpenCV file")
    camera = _camera(table)
    model = str(camera["model"]).lower()
    if model not in _MODELS:
        raise InputError(f"the model is {model} of stella_vslam, one of {', '.join(_MODELS)} is "
                         f"needed")
    distortion, names = _MODELS[model]
    check_read(camera, (*names, "model", "name"))
    k = numbers([camera[name] for name in names], "list of distortion coefficients")
    return file_lens((whole(camera["cols"], "width"), whole(camera["rows"], "height")),
                     matrix_of(*(camera[name] for name in ("fx", "fy", "cx", "cy"))),
                     partial(distortion, coefficients=k), f"stella_vslam {model}")
