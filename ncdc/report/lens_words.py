"""A lens in figures and words: focal length, field of view, distortion, and its flaws."""

from dataclasses import replace

import numpy as np

from ncdc_model.compare import fitted_plane
from ncdc_model.lens import BrownWeng, Camera, TiltedSensor

__all__ = ["lens_rows"]

_GRID = 33, 25          # positions over the picture at which flaws are measured
_SLIGHT = 0.05          # pixels: less is not worth a word


def lens_rows(camera, frame=None):
    """Rows (what, figure, words) of a table about a lens.

    Parameters
    ----------
    camera : Camera or CameraMap
        Flaws are reported of the first only.
    frame : IdealFrame, optional
        The points to which it was fitted: for the roll, and for what no smooth lens explains.
    """
    rows = [_focal(camera), _view(camera), _distortion(camera), _axis(camera)]
    if isinstance(camera, Camera):
        rows += [_decentring(camera), _tilt(camera), *_aspect(camera)]
    if frame is not None:
        rows += [_roll(frame), _rest(frame)]
    return rows


def _centre(camera):
    return np.array(camera.distort(0.0, 0.0), np.float64)


def _focal_length(camera):
    """Distorted pixels per radian on the axis."""
    step = 1e-4
    return float(np.hypot(*(np.subtract(camera.distort(step, 0.0), camera.distort(-step, 0.0))
                            / (2 * step))))


def _focal(camera):
    focal = _focal_length(camera)
    return ("Focal length", f"{focal:.1f} px", f"{focal / camera.size[0]:.2f} of the picture's "
            f"width, on the axis. Times the width of a pixel it is the focal length in millimetres")


def _view(camera):
    (width, height), middle = camera.size, (np.array(camera.size) - 1) / 2
    ends = {"across": ((0, middle[1]), (width - 1, middle[1])),
            "down": ((middle[0], 0), (middle[0], height - 1)),
            "from corner to corner": ((0, 0), (width - 1, height - 1))}
    parts = []
    for name, pair in ends.items():
        a, b = camera.undistort(*np.array(pair, np.float64).T)
        rays = np.stack([a, b, np.ones(2)], axis=1)
        rays /= np.linalg.norm(rays, axis=1, keepdims=True)
        angle = np.degrees(np.arccos(np.clip(rays[0] @ rays[1], -1, 1)))
        parts.append(f"{angle:.0f}° {name}" if np.isfinite(angle) else f"180° or more {name}")
    return "Field of view", parts[0], ", ".join(parts)


def _distortion(camera):
    """The edge in the middle of the left and right sides, compared with a lens without distortion.
    """
    centre, focal = _centre(camera), _focal_length(camera)
    x = np.array([0.0, camera.size[0] - 1.0])
    a, b = camera.undistort(x, np.full(2, centre[1]))
    share = 100 * float(np.mean(np.abs(x - centre[0]) / (focal * np.hypot(a, b)) - 1))
    if not np.isfinite(share):
        return ("Distortion", "fisheye", "the edges lie 90° or more off the axis: they have no "
                "position in a flat picture")
    kind = "barrel" if share < 0 else "pincushion"
    return ("Distortion", f"{share:+.1f} %", f"{kind}: at the left and right edges the picture is "
            f"{abs(share):.1f} % {'nearer to' if share < 0 else 'farther from'} the axis than "
            f"without distortion")


def _axis(camera):
    off = _centre(camera) - (np.array(camera.size) - 1) / 2
    words = [f"{abs(value):.1f} px {names[int(value > 0)]}"
             for value, names in zip(off, (("left of", "right of"), ("above", "below")))]
    return ("Axis", "({:.1f}, {:.1f})".format(*_centre(camera)),
            f"it meets the picture {words[0]} and {words[1]} its middle")


def _effect(camera, without):
    """Pixels, at most, by which a flaw moves points, apart from the view."""
    x, y = (part.ravel() for part in np.meshgrid(
        *(np.linspace(0, side - 1.0, count) for side, count in zip(camera.size, _GRID))))
    a, b = camera.undistort(x, y)
    known = np.isfinite(a) & np.isfinite(b)
    a, b, x, y = (part[known] for part in (a, b, x, y))
    moved = np.subtract(fitted_plane(without, a, b, x, y)(a, b), (x, y))
    return float(np.nanmax(np.hypot(*moved)))


def _decentring(camera):
    effect = _effect(camera, replace(camera, decentring=BrownWeng()))
    if effect < _SLIGHT:
        return "Decentring", f"{effect:.2f} px", "the elements of the lens are on one axis"
    return ("Decentring", f"up to {effect:.2f} px", "the elements of the lens are not quite on one "
            "axis, or not parallel, which moves points by as much")


def _tilt(camera):
    if not any(camera.tilt.angles):
        return ("Tilt", "none", "the points do not show that the sensor is tilted; a small tilt "
                "looks like decentring")
    degrees = np.degrees(np.hypot(*camera.tilt.angles))
    effect = _effect(camera, replace(camera, tilt=TiltedSensor()))
    return ("Tilt", f"{degrees:.2f}°", f"the sensor is not parallel to the lens, which moves "
            f"points by up to {effect:.2f} px")


def _aspect(camera):
    share = 100 * (camera.aspect - 1)
    if abs(share) < 0.01:
        return []
    return [("Pixels", f"{camera.aspect:.4f}", f"a pixel is {abs(share):.2f} % "
             f"{'wider than high' if share > 0 else 'higher than wide'}")]


def _roll(frame):
    matrix = frame.homographies[0]
    i, j = frame.index[frame.photo == 0].mean(axis=0)
    ends = np.array([[i - .5, j, 1], [i + .5, j, 1]]) @ matrix.T
    along = np.subtract(*(ends[:, :2] / ends[:, 2:])[::-1])
    # A row of the target may be a column of the picture.
    degrees = (np.degrees(np.arctan2(along[1], along[0])) + 45) % 90 - 45
    return ("Roll", f"{degrees:+.2f}°", f"the target of {frame.names[0] or 'the first photo'} is "
            f"turned by as much, clockwise, to the rows of the sensor: so is the camera, if the "
            f"target hung level")


def _rest(frame):
    return ("Unevenness", f"{frame.rms:.2f} px rms", "distance of the points from the best smooth "
            "lens with these flaws; noise of the points is in it. The network learns what is left")
