"""Reads the lens from a camera file of any supported program."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from ncdc_model.calibration.files import (
    colmap,
    depthai,
    matlab,
    mccalib,
    mrcal,
    nerf,
    ocam,
    opensfm,
    realsense,
    ros_ini,
    stella,
)
from ncdc_model.calibration.files.camodocal import camodocal_lens, is_camodocal
from ncdc_model.calibration.files.kalibr import is_camchain, kalibr_lens
from ncdc_model.calibration.files.known import (
    reject_known_bytes,
    reject_known_table,
    reject_known_text,
)
from ncdc_model.calibration.files.npz import npz_lens
from ncdc_model.calibration.files.opencv import opencv_lens
from ncdc_model.calibration.files.tables import is_json, table_of
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE, MIN_SIZE

__all__ = ["read_lens"]

_LARGEST = 1 << 25     # bytes: JSON of this size takes some 10 seconds of CPU time


def read_lens(path, content, camera=None, sensor=None):
    """:class:`~ncdc_model.calibration.files.lens.FileLens` of a camera file.

    Parameters
    ----------
    path : path
        Its suffix distinguishes .npz, .mat and .bin.
    content : bytes
    camera : str, optional
        Which of several cameras in the file.
    sensor : (int, int), optional
        Width and height of the frames to be corrected. The calibration is scaled to them if they
        have the same aspect.

    Raises
    ------
    InputError
        If the file is not supported, a value is bad, the camera is not chosen or absent, or the
        size is not known, out of range or of another aspect.
    """
    try:
        lens = _lens(Path(path).suffix.lower(), content, camera)
    except KeyError as error:
        raise InputError(f"the camera lacks the value {error.args[0]}") from error
    except InputError:
        raise
    except RecursionError as error:
        raise InputError("the camera is nested too deep, or holds itself") from error
    except (TypeError, ValueError, AttributeError, IndexError, OverflowError) as error:
        raise InputError(f"the camera holds a value of the wrong kind: {error}") from error
    return _checked_centre(_sized(lens, sensor))


def _lens(suffix, content, camera):
    if len(content) > _LARGEST:
        raise InputError(f"it is no camera file: it has {len(content)} bytes, the limit is "
                         f"{_LARGEST}")
    if suffix == ".npz":
        return npz_lens(content, camera)
    if suffix == ".mat" or content.startswith(b"MATLAB "):
        return matlab.mat_lens(content, camera)
    if suffix == ".bin":
        return colmap.binary_lens(content, camera)
    reject_known_bytes(content)
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise InputError(f"it is no camera file: byte {error.start} is no UTF-8 text") from error
    reject_known_text(text)
    return _of_text(text, camera)


def _of_text(text, camera):
    if is_json(text) and not mrcal.is_mrcal(text):
        return _of_table(table_of(text), camera)
    for fits, read in ((ros_ini.is_ini, ros_ini.ini_lens), (colmap.is_colmap, colmap.text_lens),
                       (matlab.is_script, matlab.script_lens)):
        if fits(text):
            return read(text, camera)
    if ocam.is_ocam(text):
        return _only(ocam.ocam_lens(text), camera)
    if mrcal.is_mrcal(text):
        return _only(mrcal.mrcal_lens(text), camera)
    if printed := realsense.printed_cameras(text):
        return realsense.realsense_lens(printed, camera)
    return _of_table(table_of(text), camera)


def _of_table(table, camera):
    if is_camchain(table):
        return kalibr_lens(table, camera)
    if is_camodocal(table):
        return _only(camodocal_lens(table), camera)
    if realsense.is_realsense(table):
        return realsense.realsense_lens(table, camera)
    if nerf.is_nerf(table):
        return nerf.nerf_lens(table, camera)
    for fits, read in ((mccalib.is_mccalib, mccalib.mccalib_lens),
                       (depthai.is_depthai, depthai.depthai_lens),
                       (opensfm.is_opensfm, opensfm.opensfm_lens)):
        if fits(table):
            return read(table, camera)
    if stella.is_stella(table):
        return _only(stella.stella_lens(table), camera)
    reject_known_table(table)
    return opencv_lens(table, camera)


def _only(lens, camera):
    if camera is not None:
        raise InputError(f"camera {camera} is asked for, the file holds one camera without a name")
    return lens


def _sized(lens, sensor):
    """``lens`` of an image of the size ``sensor``, or of its own."""
    if lens.size is None:
        if sensor is None:
            raise InputError("the file does not say the size of the image; --sensor-size WxH gives "
                             "it")
        frame = lens.frame and replace(lens.frame, size=tuple(sensor))
        lens = replace(lens, size=tuple(sensor), frame=frame)
    elif sensor is not None and tuple(sensor) != lens.size:
        lens = _scaled(lens, tuple(sensor))
    for side, value in zip(("width", "height"), lens.size):
        if not MIN_SIZE <= value <= MAX_SIZE:
            raise InputError(f"the image {side} is {value}, the limits are {MIN_SIZE} and "
                             f"{MAX_SIZE}; --sensor-size WxH scales the calibration to smaller "
                             f"frames")
    return lens


def _scaled(lens, sensor):
    scale = [new / old for new, old in zip(sensor, lens.size)]
    shapes = "the calibration is for {}x{} pixels, the sensor has {}x{}".format(*lens.size, *sensor)
    if any(abs(new - other * old) >= 1 for new, old, other in
           zip(sensor, lens.size, reversed(scale))):
        raise InputError(f"{shapes}, of another aspect: a frame that is cut needs its own "
                         f"calibration, or ROS's roi; only one that is scaled keeps the aspect")
    # Pixels are squares around their centres: the first one's corner is at -0.5 in both.
    moved = lens.moved(sensor, scale, [(part - 1) / 2 for part in scale])
    return replace(moved, notes=lens.notes + (f"{shapes}: focal lengths and centre are scaled by "
                                              f"{scale[0]:g}",))


def _checked_centre(lens):
    """``lens`` with a warning if its centre is far from the middle of the image."""
    centre = lens.matrix[:2, 2]
    if (np.abs(centre / np.array(lens.size) - .5) < .25).all():
        return lens
    return replace(lens, warnings=lens.warnings + (
        f"the principal point ({centre[0]:.1f}, {centre[1]:.1f}) is far from the middle of the "
        f"{lens.size[0]}x{lens.size[1]} image: look whether the file is for frames of this size",))
