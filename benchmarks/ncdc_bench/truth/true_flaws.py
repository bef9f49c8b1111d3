"""Flaws of a :class:`TrueLens` in the figures of :mod:`ncdc_model.flaw_figures`, and how far a
calibration is off them."""

from dataclasses import replace

import numpy as np
from scipy.optimize import least_squares

from ncdc_bench.truth.lenses import SIZE
from ncdc_model.flaw_figures import flaws_of

__all__ = ["FIGURES", "compared", "tilt_figures", "true_flaws", "true_roll"]

FIGURES = "focal_px", "axis_px", "decentring_px", "tilt_deg", "aspect", "roll_deg"
_GRID = 33, 25         # positions over the picture at which a decentring is measured
_STEP = 1e-4           # of the tangent of the view angle, for the focal length


def true_flaws(lens):
    """The true :data:`FIGURES` of a lens, but for the roll."""
    left, right, axis = lens.project([[-_STEP, 0, 1], [_STEP, 0, 1], [0, 0, 1]])
    return {"focal_px": float(np.hypot(*(right - left)) / (2 * _STEP)),
            "axis_px": float(np.hypot(*(axis - (np.array(SIZE) - 1) / 2))),
            "decentring_px": _decentring(lens),
            "tilt_deg": float(np.degrees(np.hypot(*lens.tilt))), "aspect": lens.aspect}


def true_roll(lens, page, frame):
    """The true roll, degrees, of a flat ``page``, the first photo of an :class:`IdealFrame`.

    The frame says where on the page it has measured: a detector may begin at any corner.
    """
    middle = frame.cells[0].mean(axis=0)
    ends = np.column_stack([middle + np.array([[-.5, 0], [.5, 0]]), np.ones(2)])
    corrected = ends @ frame.homographies[0].T
    xy = np.stack(frame.camera.back_map(*(corrected[:, :2] / corrected[:, 2:]).T), axis=1)
    angles = lens.angles_at(xy)
    theta = np.linalg.norm(angles, axis=1)
    rays = np.column_stack([angles * np.sinc(theta / np.pi)[:, None], np.cos(theta)])
    at = rays @ np.linalg.inv(page.plane).T
    at = at[:, :2] / at[:, 2:]
    ends = page.rays(at.mean(axis=0) + np.array([[-.5], [.5]]) * np.rint(at[1] - at[0]))
    along = np.subtract(*(ends[:, :2] / ends[:, 2:])[::-1])
    return float((np.degrees(np.arctan2(*along[::-1])) + 45) % 90 - 45)


def _decentring(lens):
    """Pixels, at most, by which OpenCV's p1 and p2 move points, apart from the view."""
    if not any(lens.k[2:4]):
        return 0.0
    without = replace(lens, k=(*lens.k[:2], 0.0, 0.0, lens.k[4]))
    xy = np.stack(np.meshgrid(*(np.linspace(0, side - 1.0, count)
                                for side, count in zip(SIZE, _GRID))), axis=-1).reshape(-1, 2)
    angles = lens.angles_at(xy)
    theta = np.linalg.norm(angles, axis=1)
    plane = np.column_stack([angles * (np.tan(theta) / theta)[:, None], np.ones(len(xy))])

    def distances(parameters):
        return without.project(plane @ np.append(parameters, 1.0).reshape(3, 3).T) - xy
    fit = least_squares(lambda p: distances(p).ravel(), np.eye(3).ravel()[:8], x_scale="jac")
    return float(np.linalg.norm(distances(fit.x), axis=1).max())


def compared(lens, page, frame):
    """Row of true figures, figures of an :class:`IdealFrame` and their standard errors:
    ``tilt_true_deg``, ``tilt_deg``, ``tilt_error_deg``, and so on.

    ``page``: of the first photo.
    """
    true = true_flaws(lens) | {"roll_deg": true_roll(lens, page, frame)}
    found, row = vars(flaws_of(frame.camera, frame)), {}
    for name in FIGURES:
        kind, _, unit = name.partition("_")
        for word, value in (("_true", true[name]), ("", found[name]),
                            ("_error", found[f"{name}_error"])):
            row[f"{kind}{word}{'_' * bool(unit)}{unit}"] = value
    return row


def tilt_figures(lens, frame):
    """``tilt_true_deg``, ``tilt_deg`` and ``tilt_error_deg`` of an :class:`IdealFrame`."""
    found = flaws_of(frame.camera, frame)
    return {"tilt_true_deg": float(np.degrees(np.hypot(*lens.tilt))), "tilt_deg": found.tilt_deg,
            "tilt_error_deg": found.tilt_deg_error}
