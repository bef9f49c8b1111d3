"""Data of ROS and OpenCV files next to the lens: rectification, projection, binning, region."""

from dataclasses import replace

import numpy as np

from ncdc_model.calibration.files.lens import flag, numbers, single
from ncdc_model.lens.frame import Frame
from ncdc_spec.errors import InputError

__all__ = ["rectified", "windowed"]

_ROTATED = 1e-3        # largest difference of R R' from 1: files are rounded


def rectified(lens, table):
    """``lens`` with the rectification_matrix (R) and projection_matrix (P) of ``table``.

    As ``cv2.initUndistortRectifyMap(K, D, R, P)``: R turns the view, P gives the corrected
    picture's focal lengths and centre. R alone is a rectification only in ROS's camera_info, as
    stereo files of OpenCV name the rotation between the cameras so. Zeros are not set.

    Raises
    ------
    InputError
        If R is no rotation, P no projection, or R may mean something else.
    """
    rotation = _value(table, "rectification_matrix", "R", (9,))
    projection = _value(table, "projection_matrix", "P", (9, 12))
    if rotation is not None:
        rotation = rotation.reshape(3, 3)
        named = {"rectification_matrix", "distortion_model"} & table.keys()
        if not named and projection is None and (rotation != np.eye(3)).any():
            raise InputError("R is given without P: named rectification_matrix it turns the view, "
                             "else leave it out")
    if rotation is not None:
        miss = np.abs(rotation @ rotation.T - np.eye(3)).max()
        if miss > _ROTATED or np.linalg.det(rotation) < 0:
            raise InputError(f"the rectification matrix R is no rotation: R R' differs from 1 by "
                             f"{miss:.2g}, the limit is {_ROTATED:g}")
        if (rotation == np.eye(3)).all():
            rotation = None
    notes = lens.notes
    if rotation is not None:
        turn = np.degrees(np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1)))
        notes += (f"the view is turned by {turn:.2f} degrees, as the rectification matrix says",)
    return replace(lens, rotation=rotation, frame=_frame(lens.size, projection), notes=notes)


def _value(table, name, short, counts):
    """Numbers of the value ``name``, or of its ``short`` name in camera_info; None if not set."""
    value = table.get(name)
    # Without K and D, or with a translation, R and P mean something else.
    for key, others in ((short, {"K", "D"}), (short.lower(), {"k", "d"})):
        if value is None and others <= table.keys() and "T" not in table:
            value = table.get(key)
    if value is None:
        return None
    array = numbers(value, name.replace("_", " "))
    if array.size not in counts:
        raise InputError(f"the {name.replace('_', ' ')} has {array.size} numbers, "
                         f"{' or '.join(map(str, counts))} are needed")
    return array if array.any() else None


def _frame(size, projection):
    if projection is None:
        return None
    p = projection.reshape(3, -1)[:, :3]
    if not (p[0, 0] > 0 and p[1, 1] > 0) or p[0, 1] or p[1, 0] or (p[2] != (0, 0, 1)).any():
        raise InputError(f"the projection matrix P is {p.tolist()}, [[fx, 0, cx], [0, fy, cy], "
                         f"[0, 0, 1]] is needed")
    return Frame(size, float(p[0, 0]), (float(p[0, 2]), float(p[1, 2])),
                 float(p[1, 1] / p[0, 0]))


def windowed(lens, table):
    """``lens`` of the frames after the binning and roi of a camera_info.

    K and P are for the full resolution: less the offset of the roi and divided by the binning,
    as ROS's image_geometry does. do_rectify chooses a part of the corrected picture,
    not how the picture is computed.

    Raises
    ------
    InputError
        If the roi leaves the image, a value is no whole number or negative, or K is already that
        of binned frames.
    """
    binning = [max(1, _count(table.get(name) or 0, name)) for name in ("binning_x", "binning_y")]
    roi = table.get("roi") or {}
    if not isinstance(roi, dict):
        raise InputError(f"roi is {roi!r}, names and values are needed")
    x, y, width, height = (_count(roi.get(name) or 0, f"roi {name}")
                           for name in ("x_offset", "y_offset", "width", "height"))
    flag(roi.get("do_rectify"), "roi do_rectify")
    if binning == [1, 1] and not any((x, y, width, height)):
        return lens
    if lens.size is None:
        raise InputError("binning and roi need the width and height of the full image")
    if not (width or height):
        width, height = lens.size[0] - x, lens.size[1] - y
    for side, offset, length, full in (("x", x, width, lens.size[0]),
                                       ("y", y, height, lens.size[1])):
        if length < 1 or offset + length > full:
            raise InputError(f"the roi spans pixels {offset} to {offset + length} in {side}, the "
                             f"image has {full}")
    size = width // binning[0], height // binning[1]
    _check_binning(lens, binning, size)
    notes = [f"the frames have {size[0]}x{size[1]} pixels"]
    if binning != [1, 1]:
        notes.append(f"binning is {binning[0]}x{binning[1]}")
    if (x, y, width, height) != (0, 0, *lens.size):
        notes.append(f"the roi starts at ({x}, {y})")
    scale = [1 / part for part in binning]
    moved = lens.moved(size, scale, [-x * scale[0], -y * scale[1]])
    return replace(moved, notes=lens.notes + (": ".join([notes[0], ", ".join(notes[1:])]),))


def _check_binning(lens, binning, size):
    """Reject a matrix calibrated on binned frames, which must not be divided again."""
    centre, full = lens.matrix[:2, 2], np.array(lens.size)
    already = (centre < full / 3) & (np.abs(centre - np.array(size) / 2) < np.array(size) / 4)
    if (already & (np.array(binning) > 1)).any():
        raise InputError(
            f"binning_x and binning_y are {binning[0]} and {binning[1]}, but the camera matrix "
            f"has its centre at ({centre[0]:.1f}, {centre[1]:.1f}), near the middle of the binned "
            f"{size[0]}x{size[1]} and not of {lens.size[0]}x{lens.size[1]}: if it is that of "
            f"binned frames, set width and height to theirs and the binning to 1")


def _count(value, name):
    number = single(value, name)
    if number != int(number) or number < 0:
        raise InputError(f"{name} is {number:g}, a whole number from 0 on is needed")
    return int(number)
