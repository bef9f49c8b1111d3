"""Files of a gyroscope's samples: CSV, a line each."""

import re

import numpy as np

from ncdc_model.stabilise.orientation import Gyroscope
from ncdc_spec.errors import InputError
from ncdc_spec.files import parse_text

__all__ = ["COLUMNS", "load_gyroscope"]

COLUMNS = ("time_s", "x_rad_s", "y_rad_s", "z_rad_s")
_IN_DEGREES = ("time_s", "x_deg_s", "y_deg_s", "z_deg_s")
_FASTEST = 35.0         # rad/s: 2,000 degrees per second, where the range of such sensors ends
_SLOWEST_STEP = 0.1     # s from sample to sample: rarer ones do not show a hand's shaking
_GAP = 5                # times the usual step
_AXES = re.compile(r"([+-]?)([xyz])")


def load_gyroscope(path, axes="x,y,z"):
    """Read the samples of the CSV file ``path``; returns a :class:`Gyroscope`.

    The first line has the names :data:`COLUMNS`, or ``x_deg_s`` and so on for rates in degrees per
    second. Rates are about the axes of the sensor.

    Parameters
    ----------
    path : path
    axes : str
        The sensor's axes that are the camera's x (right), y (down) and z (forward), each with a
        minus where it points the other way: ``x,y,z``, or ``-y,x,z``.

    Raises
    ------
    InputError
        If the file cannot be read, a value is no number, times do not rise, samples are missing,
        the units are probably others, or ``axes`` are no axes of a right-handed system.
    """
    turn = _axes(axes)
    head, *lines = parse_text(path, "gyroscope file", str.splitlines) or [""]
    names = tuple(name.strip() for name in head.split(","))
    if names not in (COLUMNS, _IN_DEGREES):
        raise InputError(f"{path} begins with {head!r}, a line {','.join(COLUMNS)} is needed, or "
                         f"{','.join(_IN_DEGREES)}")
    values = np.array([_numbers(path, number, line) for number, line in enumerate(lines, 2)
                       if line.strip()])
    if len(values) < 2:
        raise InputError(f"{path} holds {len(values)} samples, at least 2 are needed")
    if names == _IN_DEGREES:
        values[:, 1:] = np.radians(values[:, 1:])
    _check(path, values)
    return Gyroscope(values[:, 0], values[:, 1:] @ turn.T)


def _numbers(path, number, line):
    try:
        values = [float(text) for text in line.split(",")]
    except ValueError:
        values = []
    if len(values) != len(COLUMNS) or not np.isfinite(values).all():
        raise InputError(f"line {number} of {path} is {line!r}, {len(COLUMNS)} finite "
                         f"numbers are needed")
    return values


def _check(path, values):
    """Raise :class:`InputError` unless times rise evenly and the units are plausible."""
    steps = np.diff(values[:, 0])
    if (steps <= 0).any():
        k = int(np.argmax(steps <= 0))
        raise InputError(f"the time {values[k + 1, 0]:g} s in {path} follows {values[k, 0]:g} s, "
                         f"times must rise")
    usual = float(np.median(steps))
    if usual > _SLOWEST_STEP:
        raise InputError(f"the samples of {path} are {usual:g} s apart, {_SLOWEST_STEP:g} s is the "
                         f"limit: is the time in seconds?")
    if steps.max() > _GAP * usual:
        k = int(steps.argmax())
        raise InputError(f"{path} has a gap of {steps[k]:g} s after {values[k, 0]:g} s, the limit "
                         f"is {_GAP} times the usual step of {usual:g} s")
    fastest = np.abs(values[:, 1:]).max()
    if fastest > _FASTEST:
        raise InputError(f"a rate in {path} is {fastest:g} rad/s, {_FASTEST:g} is the limit: "
                         f"columns of degrees per second are named x_deg_s, y_deg_s, z_deg_s")


def _axes(text):
    """3x3 matrix from the sensor's axes to the camera's."""
    found = [_AXES.fullmatch(part.strip()) for part in text.split(",")]
    turn = np.zeros((3, 3))
    if len(found) == 3 and all(found):
        for row, match in enumerate(found):
            turn[row, "xyz".index(match[2])] = -1 if match[1] == "-" else 1
    if round(np.linalg.det(turn)) != 1:
        raise InputError(f"the axes are {text!r}, three such as -y,x,z of a right-handed system "
                         f"are needed")
    return turn
