"""Accuracy of a calibration: straightness on held-out points, and its floor."""

import numpy as np

from ncdc_model.calibration.straightness import corrected_positions, straightness
from ncdc_model.calibration.target_flatness import line_scatter, polynomial

__all__ = ["COMMON_WIDTH", "measure_map", "measure_smooth"]

COMMON_WIDTH = 1280    # corrected pixels: scale for figures of pictures of different size

_FOLDS = 7


def measure_smooth(frame):
    """Straightness of an :class:`IdealFrame` by cross-validation, without a network.

    Each seventh of the points is corrected by the smooth lens and by a polynomial in column and row
    per photo that were fitted to the other six. The result is a dict as of :func:`measure_map`.
    """
    back_map = frame.camera.back_map
    rest = frame.distorted - np.stack(back_map(*frame.corrected.T), axis=1)
    predicted = np.zeros_like(rest)
    fold = np.random.default_rng(1).integers(0, _FOLDS, len(rest))
    for number, degree in enumerate(frame.degrees):
        on = frame.photo == number
        # Three points for each of the polynomial's terms, or a lower degree.
        while 3 * (degree + 1) * (degree + 2) / 2 > on.sum() and degree > 1:
            degree -= 1
        for k in range(_FOLDS if on.any() else 0):
            terms = polynomial(frame.index[on], degree)
            out = fold[on] == k
            solution = np.linalg.lstsq(terms[~out], rest[on][~out], rcond=1e-9)[0]
            predicted[np.flatnonzero(on)[out]] = terms[out] @ solution
    return _measure(frame, back_map, frame.distorted - predicted)


def measure_map(frame, back_map, measured=None):
    """Straightness of the target's rows and columns in the picture that ``back_map`` corrects.

    Parameters
    ----------
    frame : IdealFrame
    back_map : callable
        (u, v) -> (x, y).
    measured : ndarray of bool, shape (n,), optional
        Points of ``frame`` that are measured: those held out of training.

    Returns
    -------
    dict
        ``straightness_rms_px``, ``straightness_max_px``, ``straightness_lines`` and
        ``straightness_by_line``, in corrected pixels; ``straightness_rms_px_at_1280``: the rms
        for a picture scaled to a width of 1280; ``straightness_as_flat_rms_px``: the same with
        the target's relief left in; ``relief_rms_px``: distorted pixels, 0 for a flat target;
        ``repeatability_px``: scatter of a point about its line's smooth course, rms on one axis,
        distorted pixels; ``straightness_floor_rms_px``: straightness due to it alone. The last
        two are not-a-number if no photo has 200 points.
    """
    return _measure(frame, back_map, frame.distorted, measured)


def _measure(frame, back_map, distorted, measured=None):
    def positions(xy):
        return corrected_positions(back_map, frame.corrected, xy)

    def result(xy):
        return straightness(positions(xy), frame.index, frame.photo, measured)
    straight = result(distorted)
    across = np.stack([-frame.along[:, 1], frame.along[:, 0]], axis=1)
    magnified = np.linalg.norm(positions(frame.distorted + across) - positions(frame.distorted),
                               axis=1)
    scatter, floor = [], []
    for number in range(len(frame.names)):
        on = frame.photo == number
        taken = frame.index[on], frame.distorted[on] + frame.relief[on]
        if frame.on_target is not frame.index:
            # The distances differ from corner to corner: their smooth course is the lens's.
            taken = taken[0], taken[1] - np.stack(back_map(*frame.corrected[on].T), axis=1)
        scatter.append(line_scatter(*taken, across[on]))
        floor.append(line_scatter(*taken, across[on] * magnified[on, None]))
    lines = [{**line, "photo": frame.names[line["photo"]]} for line in straight.by_line]
    bent = frame.relief.any()
    return {"straightness_rms_px": straight.rms, "straightness_max_px": straight.max,
            "straightness_lines": straight.lines,
            "straightness_rms_px_at_1280": straight.rms * COMMON_WIDTH / frame.camera.frame.size[0],
            "straightness_as_flat_rms_px": result(distorted + frame.relief).rms if bent
            else straight.rms,
            "straightness_floor_rms_px": _rms(np.concatenate(floor)),
            "repeatability_px": _rms(np.concatenate(scatter)),
            "relief_rms_px": float(np.sqrt(np.mean((frame.relief**2).sum(axis=1)))),
            "straightness_by_line": lines}


def _rms(values):
    return float(np.sqrt(np.mean(values**2))) if len(values) else float("nan")
