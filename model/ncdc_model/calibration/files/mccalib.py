"""Cameras of MC-Calib: calibrated_cameras_data.yml."""

from functools import partial

from ncdc_model.calibration.files.distortion import fisheye, perspective
from ncdc_model.calibration.files.lens import choose, coefficients, file_lens, single, whole
from ncdc_model.calibration.files.opencv import camera_matrix
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_mccalib", "mccalib_lens"]

_READ = "camera_matrix", "distortion_vector", "distortion_type", "img_width", "img_height"
# Name, distortion and number of coefficients of each distortion_type.
_TYPES = {0: ("Brown", perspective, 5), 1: ("Kannala-Brandt", fisheye, 4)}


def is_mccalib(table):
    """Whether the names and values are those of the cameras of MC-Calib."""
    return bool(_cameras(table))


def _cameras(table):
    return {name: value for name, value in table.items() if isinstance(value, dict)
            and {"distortion_vector", "distortion_type"} & value.keys()}


def mccalib_lens(table, camera=None):
    """:class:`FileLens` of one of the cameras camera_0, camera_1 ...

    distortion_type 0 is Brown's with k1 k2 p1 p2 k3, 1 OpenCV's fisheye with k1 to k4.

    Raises
    ------
    InputError
        If the camera is not chosen or absent, or the distortion is of another type or length.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    cameras = _cameras(table)
    check_read(table, cameras)
    entry = cameras[choose(cameras, camera)]
    check_read(entry, _READ)
    kind = single(entry["distortion_type"], "distortion_type")
    if kind not in _TYPES:
        raise InputError(f"the distortion_type is {kind:g}, 0 (Brown) or 1 (Kannala-Brandt) is "
                         f"needed")
    name, distortion, count = _TYPES[kind]
    k = coefficients(entry["distortion_vector"], name, (count,))
    size = whole(entry["img_width"], "width"), whole(entry["img_height"], "height")
    return file_lens(size, camera_matrix(entry["camera_matrix"]),
                     partial(distortion, coefficients=k), f"MC-Calib {name}")
