"""A lens in figures and words: focal length, field of view, distortion, and its flaws."""

import numpy as np

from ncdc_model.calibration.page_bend import PHOTOS
from ncdc_model.flaw_figures import (
    SAG,
    axis_pixel,
    decentring,
    flaws_of,
    focal_length,
    sag_effect,
    tilt,
    tilt_effect,
)
from ncdc_model.lens import Camera

__all__ = ["lens_rows"]

_SLIGHT = 0.05          # pixels: less is not worth a word
_VAGUE = 0.01           # of the focal length: a larger standard error needs a word


def lens_rows(camera, frame=None):
    """Rows (what, figure, words) of a table about a lens.

    Parameters
    ----------
    camera : Camera or CameraMap
        Flaws are reported of the first only.
    frame : IdealFrame, optional
        The points to which it was fitted: for the roll, and for what no smooth lens explains.
    """
    flaws = flaws_of(camera, frame) if frame is not None else None
    rows = [_focal(camera, flaws), _view(camera), _distortion(camera), _axis(camera, flaws)]
    if isinstance(camera, Camera):
        rows += [_decentring(camera, flaws), _tilt(camera, flaws), *_aspect(camera, flaws)]
    if frame is not None:
        rows += [_roll(frame, flaws), _page(camera, frame), _rest(frame)]
    return rows


def _error(flaws, name, digits):
    """Plus-minus and the standard error of a figure; empty where there is none."""
    return "" if flaws is None else f" ± {getattr(flaws, name):.{digits}f}"


def _focal(camera, flaws):
    focal = focal_length(camera)
    words = (f"{focal / camera.size[0]:.2f} of the picture's width, on the axis. Times the width "
             f"of a pixel it is the focal length in millimetres")
    if flaws is not None and flaws.focal_px_error > _VAGUE * focal:
        words += (". These photos hardly determine it: photos of the target from other sides, "
                  "tilted by 20 degrees or more, do")
    return "Focal length", f"{focal:.1f}{_error(flaws, 'focal_px_error', 1)} px", words


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


def _axis(camera, flaws):
    off = axis_pixel(camera) - (np.array(camera.size) - 1) / 2
    words = [f"{abs(value):.1f} px {names[int(value > 0)]}"
             for value, names in zip(off, (("left of", "right of"), ("above", "below")))]
    place = "({:.1f}, {:.1f})".format(*axis_pixel(camera))
    return ("Axis", f"{place}{_error(flaws, 'axis_px_error', 1)}",
            f"it meets the picture {words[0]} and {words[1]} its middle")


def _decentring(camera, flaws):
    effect, error = decentring(camera), _error(flaws, "decentring_px_error", 2)
    if effect < _SLIGHT:
        return "Decentring", f"{effect:.2f}{error} px", "the elements of the lens are on one axis"
    return ("Decentring", f"up to {effect:.2f}{error} px", "the elements of the lens are not quite "
            "on one axis, or not parallel, which moves points by as much")


def _tilt(camera, flaws):
    figure = f"{tilt(camera):.2f}{_error(flaws, 'tilt_deg_error', 2)}°"
    if not any(camera.tilt.angles):
        if flaws is None:
            return "Tilt", "none", "the sensor is parallel to the lens"
        return ("Tilt", figure, "the points do not show that the sensor is tilted; a tilt of up to "
                f"{2 * flaws.tilt_deg_error:.1f}° would look the same")
    return ("Tilt", figure, f"the sensor is not parallel to the lens, which moves points by up to "
            f"{tilt_effect(camera):.2f} px")


def _aspect(camera, flaws):
    share = 100 * (camera.aspect - 1)
    if abs(share) < 0.01:
        return []
    shape = "wider than high" if share > 0 else "higher than wide"
    return [("Pixels", f"{camera.aspect:.4f}{_error(flaws, 'aspect_error', 4)}",
             f"a pixel is {abs(share):.2f} % {shape}")]


def _roll(frame, flaws):
    return ("Roll", f"{flaws.roll_deg:+.2f}{_error(flaws, 'roll_deg_error', 2)}°",
            f"the target of {frame.names[0] or 'the first photo'} is turned by as much, clockwise, "
            f"to the rows of the sensor: so is the camera, if the target hung level")


def _page(camera, frame):
    sag, error = frame.sag
    if sag:
        return ("Page", f"bent by {100 * sag:.2f} ± {100 * error:.2f} %", "of its length: the "
                "photos from several sides prove it, and it is taken off the points")
    if len(frame.names) >= PHOTOS:
        return "Page", "flat", "the photos from several sides show no bend"
    rms, most = sag_effect(camera, frame, SAG)
    return ("Page", "not known", f"few photos do not show whether the page is flat: each "
            f"{100 * SAG:.1f} % of sag moves the map by up to {most:.2f} px, {rms:.2f} px rms. "
            f"Three photos from different sides show it")


def _rest(frame):
    return ("Unevenness", f"{frame.rms:.2f} px rms", "distance of the points from the best smooth "
            "lens with these flaws; noise of the points is in it. The network learns what is left")
