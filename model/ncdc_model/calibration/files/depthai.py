"""Calibration of an OAK camera, as DepthAI writes its EEPROM: JSON with cameraData."""

from functools import partial

from ncdc_model.calibration.files.distortion import fisheye, perspective
from ncdc_model.calibration.files.lens import (
    UNBENT,
    choose,
    coefficients,
    file_lens,
    numbers,
    single,
    whole,
)
from ncdc_model.calibration.files.opencv import camera_matrix
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["depthai_lens", "is_depthai"]

_READ = ("cameraType", "distortionCoeff", "extrinsics", "height", "intrinsicMatrix", "lensPosition",
         "specHfovDeg", "measuredFovDeg", "width")
# Name, distortion and numbers of coefficients of each cameraType.
_TYPES = {0: ("perspective", perspective, (14, 12, 8, 5, 4)), 1: ("fisheye", fisheye, (4,))}


def is_depthai(table):
    """Whether the names and values are those of an OAK camera."""
    return "cameraData" in table


def depthai_lens(table, camera=None):
    """:class:`FileLens` of one socket, CAM_A, CAM_B ...; only calibrated ones count.

    cameraType 0 is OpenCV's perspective model with up to 14 coefficients, 1 its fisheye, of whose
    list the first four count; others must be 0.

    Raises
    ------
    InputError
        If no socket is calibrated, the camera is not chosen or absent, or its type is another.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    sockets = {f"CAM_{chr(ord('A') + int(socket))}": entry for socket, entry in table["cameraData"]
               if numbers(entry["intrinsicMatrix"], "intrinsicMatrix").any()}
    if not sockets:
        raise InputError("it is a DepthAI (OAK) file without a calibrated camera: each "
                         "intrinsicMatrix is empty")
    camera = choose(sorted(sockets), camera)
    entry = sockets[camera]
    check_read(entry, _READ)
    kind = single(entry["cameraType"], "cameraType")
    if kind not in _TYPES:
        raise InputError(f"{camera} has the cameraType {kind:g} of DepthAI, 0 (perspective) or 1 "
                         f"(fisheye) is needed")
    name, distortion, allowed = _TYPES[kind]
    k = coefficients(entry["distortionCoeff"], name, allowed)
    size = whole(entry["width"], "width"), whole(entry["height"], "height")
    return file_lens(size, camera_matrix(entry["intrinsicMatrix"]),
                     partial(distortion, coefficients=k), f"DepthAI {camera} {name}",
                     warnings=() if entry["distortionCoeff"] else (UNBENT,))
