"""Manufacturing flaws of a calibrated camera in figures: focal length, axis, decentring, tilt,
roll."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_model.compare import fitted_plane
from ncdc_model.lens import BrownWeng, TiltedSensor

__all__ = ["Flaws", "axis_pixel", "decentring", "effect", "flaws_of", "focal_length", "roll",
           "tilt", "tilt_effect"]

_GRID = 33, 25          # positions over the picture at which flaws are measured


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
    roll_deg : float
        :func:`roll` of the first photo.
    uneven_px : float
        Root mean square distance of the points from the smooth lens.
    """
    focal_px: float
    axis_px: float
    decentring_px: float
    tilt_deg: float
    roll_deg: float
    uneven_px: float


def flaws_of(camera, frame):
    """:class:`Flaws` of a :class:`Camera` and the :class:`IdealFrame` it was fitted in."""
    off = axis_pixel(camera) - (np.array(camera.size) - 1) / 2
    return Flaws(focal_length(camera), float(np.hypot(*off)), decentring(camera), tilt(camera),
                 roll(frame), frame.rms)


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


def roll(frame):
    """Degrees, clockwise, by which the target of the first photo is turned to the sensor's rows.

    A row of the target may be a column of the picture: the result lies in -45..45.
    """
    i, j = frame.on_target[frame.photo == 0].mean(axis=0)
    ends = np.array([[i - .5, j, 1], [i + .5, j, 1]]) @ frame.homographies[0].T
    along = np.subtract(*(ends[:, :2] / ends[:, 2:])[::-1])
    return float((np.degrees(np.arctan2(along[1], along[0])) + 45) % 90 - 45)


def effect(camera, without):
    """Pixels, at most, by which a flaw moves points, apart from the view.

    ``without``: the same :class:`Camera` without the flaw.
    """
    x, y = (part.ravel() for part in np.meshgrid(
        *(np.linspace(0, side - 1.0, count) for side, count in zip(camera.size, _GRID))))
    a, b = camera.undistort(x, y)
    known = np.isfinite(a) & np.isfinite(b)
    a, b, x, y = (part[known] for part in (a, b, x, y))
    moved = np.subtract(fitted_plane(without, a, b, x, y)(a, b), (x, y))
    return float(np.nanmax(np.hypot(*moved)))
