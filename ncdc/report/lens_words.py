"""A lens in figures and words: focal length, field of view, distortion, and its flaws."""

import numpy as np

from ncdc_model.flaw_figures import (
    axis_pixel,
    decentring,
    focal_length,
    roll,
    tilt,
    tilt_effect,
)
from ncdc_model.lens import Camera

__all__ = ["lens_rows"]

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


def _focal(camera):
    focal = focal_length(camera)
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
    centre, focal = axis_pixel(camera), focal_length(camera)
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
    off = axis_pixel(camera) - (np.array(camera.size) - 1) / 2
    words = [f"{abs(value):.1f} px {names[int(value > 0)]}"
             for value, names in zip(off, (("left of", "right of"), ("above", "below")))]
    return ("Axis", "({:.1f}, {:.1f})".format(*axis_pixel(camera)),
            f"it meets the picture {words[0]} and {words[1]} its middle")


def _decentring(camera):
    effect = decentring(camera)
    if effect < _SLIGHT:
        return "Decentring", f"{effect:.2f} px", "the elements of the lens are on one axis"
    return ("Decentring", f"up to {effect:.2f} px", "the elements of the lens are not quite on one "
            "axis, or not parallel, which moves points by as much")


def _tilt(camera):
    if not any(camera.tilt.angles):
        return ("Tilt", "none", "the points do not show that the sensor is tilted; a small tilt "
                "looks like decentring")
    return ("Tilt", f"{tilt(camera):.2f}°", f"the sensor is not parallel to the lens, which moves "
            f"points by up to {tilt_effect(camera):.2f} px")


def _aspect(camera):
    share = 100 * (camera.aspect - 1)
    if abs(share) < 0.01:
        return []
    return [("Pixels", f"{camera.aspect:.4f}", f"a pixel is {abs(share):.2f} % "
             f"{'wider than high' if share > 0 else 'higher than wide'}")]


def _roll(frame):
    return ("Roll", f"{roll(frame):+.2f}°",
            f"the target of {frame.names[0] or 'the first photo'} is turned by as much, clockwise, "
            f"to the rows of the sensor: so is the camera, if the target hung level")


def _rest(frame):
    return ("Unevenness", f"{frame.rms:.2f} px rms", "distance of the points from the best smooth "
            "lens with these flaws; noise of the points is in it. The network learns what is left")
