"""Manufacturing flaws of a calibrated camera in figures: focal length, axis, decentring, tilt,
aspect, roll, each with its standard error."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_model.calibration.page_bend import bent_lenses
from ncdc_model.calibration.smooth import SmoothFit
from ncdc_model.calibration.smooth_vector import (
    ASPECT,
    DECENTRING,
    LENS,
    TILT,
    lens_of,
    planes_of,
)
from ncdc_model.fitted_plane import fitted_plane
from ncdc_model.lens import BrownWeng, TiltedSensor

__all__ = ["SAG", "Flaws", "axis_pixel", "decentring", "effect", "flaws_of", "focal_length",
           "sag_effect", "tilt", "tilt_effect"]

SAG = 0.001             # of a page's extent: a bend whose effect is stated
_GRID = 33, 25          # positions over the picture at which flaws are measured
_EXACT = 1e-6           # pixels: less is no effect


@dataclass(frozen=True)
class Flaws:
    """What a calibration says of one camera.

    Parameters
    ----------
    focal_px : float
        Focal length on the axis in distorted pixels per radian.
    axis_px : float
        Distance of the optical axis from the middle of the picture.
    decentring_px, tilt_deg : float
        :func:`decentring` and :func:`tilt`.
    aspect : float
        Width of a pixel over its height.
    roll_deg : float
        Degrees, clockwise, by which the target of the first photo is turned to the sensor's rows.
        A row of the target may be a column of the picture: the result lies in -45..45.
    uneven_px : float
        Root mean square distance of the points from the smooth lens.
    focal_px_error, axis_px_error, decentring_px_error, tilt_deg_error, aspect_error, \
roll_deg_error : float
        Their standard errors, from the covariance of the fit
        (:mod:`ncdc_model.calibration.smooth_errors`).
    """
    focal_px: float
    axis_px: float
    decentring_px: float
    tilt_deg: float
    aspect: float
    roll_deg: float
    uneven_px: float
    focal_px_error: float
    axis_px_error: float
    decentring_px_error: float
    tilt_deg_error: float
    aspect_error: float
    roll_deg_error: float


def flaws_of(camera, frame):
    """:class:`Flaws` of a :class:`Camera` and the :class:`IdealFrame` it was fitted in."""
    off = axis_pixel(camera) - (np.array(camera.size) - 1) / 2
    vector, covariance = frame.fits[-1].vector, frame.estimate.lens
    roll, roll_error = _roll(frame, vector)
    return Flaws(
        focal_px=focal_length(camera), axis_px=float(np.hypot(*off)),
        decentring_px=decentring(camera), tilt_deg=tilt(camera), aspect=float(camera.aspect),
        roll_deg=roll, uneven_px=frame.rms, focal_px_error=float(np.sqrt(covariance[0, 0])),
        axis_px_error=_magnitude_error(off, covariance[1:3, 1:3]),
        decentring_px_error=_decentring_error(camera, vector, covariance),
        tilt_deg_error=float(np.degrees(_magnitude_error(vector[TILT], covariance[TILT, TILT]))),
        aspect_error=float(np.sqrt(covariance[ASPECT, ASPECT])), roll_deg_error=roll_error)


def axis_pixel(camera):
    """Distorted pixel (x, y) of the optical axis."""
    return np.array(camera.distort(0.0, 0.0), np.float64)


def focal_length(camera):
    """Distorted pixels per radian on the axis."""
    step = 1e-4
    return float(np.hypot(*(np.subtract(camera.distort(step, 0.0), camera.distort(-step, 0.0))
                            / (2 * step))))


def decentring(camera):
    """Pixels, at most, by which decentred elements of the lens move points."""
    return effect(camera, replace(camera, decentring=BrownWeng()))


def tilt(camera):
    """Angle in degrees between the sensor and the plane that is normal to the axis."""
    return float(np.degrees(np.hypot(*camera.tilt.angles)))


def tilt_effect(camera):
    """Pixels, at most, by which the tilt of the sensor moves points."""
    return effect(camera, replace(camera, tilt=TiltedSensor()))


def sag_effect(camera, frame, sag):
    """Pixels, root mean square and at most, by which the map of ``camera`` is off if the page was
    bent to a cylinder by ``sag``, in parts of its extent, and the photos of the
    :class:`IdealFrame` do not show it: along its columns or its rows, what is more.
    """
    fit, found = SmoothFit.of(camera.size, frame.fits[-1]), []
    for bent in bent_lenses(camera.size, frame.cells, fit, sag):
        far = np.hypot(*_moved(camera, replace(bent, frame=camera.frame)))
        found.append((float(np.sqrt(np.nanmean(far**2))), float(np.nanmax(far))))
    return max(found, key=lambda pair: pair[1])


def effect(camera, without):
    """Pixels, at most, by which a flaw moves points, apart from the view.

    ``without``: the same :class:`Camera` without the flaw.
    """
    return float(np.nanmax(np.hypot(*_moved(camera, without))))


def _moved(camera, without):
    """Pixels (2, n) by which a flaw moves points all over the picture, apart from the view;
    not-a-number where the lens sees nothing."""
    x, y = (part.ravel() for part in np.meshgrid(
        *(np.linspace(0, side - 1.0, count) for side, count in zip(camera.size, _GRID))))
    a, b = camera.undistort(x, y)
    known = np.isfinite(a) & np.isfinite(b)
    moved = np.full((2, len(x)), np.nan)
    a, b, x, y = (part[known] for part in (a, b, x, y))
    moved[:, known] = np.subtract(fitted_plane(without, a, b, x, y)(a, b), (x, y))
    return moved


def _magnitude_error(vector, covariance):
    """Standard error of the length of a ``vector`` (2,): along it, or if it is zero, along the
    direction of the largest."""
    length = np.hypot(*vector)
    if length:
        return float(np.sqrt(vector @ covariance @ vector) / length)
    return float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))


def _decentring_error(camera, vector, covariance):
    """Standard error of :func:`decentring`, in pixels: where the decentring moves points most."""
    size, direction = np.linalg.eigh(covariance[DECENTRING, DECENTRING])
    changed = vector[:LENS].copy()
    moved = _moved(camera, replace(camera, decentring=BrownWeng()))
    changes = []
    for deviation in (direction * np.sqrt(np.maximum(size, 0))).T:
        changed[DECENTRING] = vector[DECENTRING] + deviation
        changes.append(_moved(replace(camera, decentring=lens_of(changed).decentring), camera))
    changes = np.nan_to_num(changes)                        # (6, 2, n)
    at = int(np.nanargmax(np.hypot(*moved)))
    if np.hypot(*moved[:, at]) < _EXACT:
        at = int((changes**2).sum(axis=(0, 1)).argmax())
    spread = changes[:, :, at]
    return _magnitude_error(moved[:, at], spread.T @ spread)


def _roll(frame, vector):
    """Roll of the first photo and its standard error, both in degrees; see :class:`Flaws`."""
    middle = frame.index[frame.photo == 0].mean(axis=0)

    def angle(vector):
        first, second, shift = planes_of(vector)[0].T
        ends = [first * (middle[0] + half) + second * middle[1] + shift for half in (-.5, .5)]
        return np.degrees(np.arctan2(*np.subtract(*(end[:2] / end[2] for end in ends[::-1]))[::-1]))
    pose = slice(LENS, LENS + 6)
    changes = []
    for number in range(LENS, LENS + 6):
        step = np.zeros(len(vector))
        step[number] = 1e-6 * max(1.0, abs(vector[number]))
        change = angle(vector + step) - angle(vector - step)
        changes.append((change + 180) % 360 - 180)
        changes[-1] /= 2 * step[number]
    error = np.sqrt(max(changes @ frame.estimate.covariance[pose, pose] @ changes, 0.0))
    return float((angle(vector) + 45) % 90 - 45), float(error)
