"""The .ini of ROS's camera_calibration_parsers, made by ``camera_calibration`` as ost.txt."""

import re

from ncdc_model.calibration.files.opencv import opencv_lens
from ncdc_model.calibration.files.unread import may_bend
from ncdc_spec.errors import InputError

__all__ = ["ini_lens", "is_ini"]

_MATRICES = {"camera matrix": ("camera_matrix", 3), "distortion": ("distortion_coefficients", 1),
             "rectification": ("rectification_matrix", 3), "projection": ("projection_matrix", 3)}


def is_ini(text):
    """Whether ``text`` is such a file."""
    return re.search(r"(?m)^\[image\]\s*$", text) is not None and "camera matrix" in text


def ini_lens(text, camera=None):
    """:class:`FileLens` of the file: five coefficients are plumb_bob's, eight rational.

    Raises
    ------
    InputError
        If a value is no number, or as of :func:`~ncdc_model.calibration.files.opencv.opencv_lens`.
    KeyError
        If a value is missing.
    """
    lines = [line.strip() for line in text.splitlines()]
    lines = [line for line in lines if line and line[0] not in "#;"]
    table = {}
    for k, line in enumerate(lines):
        if line in ("width", "height"):
            table[line] = _row(lines, k + 1)[0]
        elif line in _MATRICES:
            name, rows = _MATRICES[line]
            table[name] = [value for row in range(rows) for value in _row(lines, k + 1 + row)]
    names = [line[1:-1] for line in lines if line.startswith("[") and line.endswith("]")]
    names = [name for name in names if name not in ("image", "externals")]
    unread = [line for line in lines if line not in _MATRICES and may_bend(line.strip("[]"))
              and line.strip("[]") not in names]
    if unread:
        raise InputError(f"the line {unread[0]!r} may be distortion, only one named distortion is "
                         f"read")
    count = len(table["distortion_coefficients"])
    table["distortion_model"] = "rational_polynomial" if count > 5 else "plumb_bob"
    return opencv_lens(table, None if camera in names else camera)


def _row(lines, k):
    line = lines[k] if k < len(lines) else ""
    try:
        return [float(part) for part in line.split()]
    except ValueError as error:
        raise InputError(f"the line {line!r} stands where numbers are needed") from error
