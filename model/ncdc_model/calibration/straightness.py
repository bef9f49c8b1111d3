"""Straightness of a flat target's rows and columns in the corrected picture."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Straightness", "corrected_positions", "straightness"]

_STEP = 1.0            # corrected pixels: to either side, for the change of a map


@dataclass(frozen=True)
class Straightness:
    """Distances, in pixels, of points from the straight lines fitted to their rows and columns.

    Parameters
    ----------
    rms, max : float
        Over all lines.
    lines : int
    by_line : tuple of dict
        ``photo``, ``column`` or ``row`` (its number), ``points``, ``rms_px`` and ``max_px``.
    """
    rms: float
    max: float
    lines: int
    by_line: tuple


def straightness(uv, index, photo=None, measured=None):
    """Fit a line to every row and column of a flat target.

    Parameters
    ----------
    uv : ndarray, shape (n, 2)
        The target's points in the corrected picture (or any other), in pixels.
    index : ndarray of int, shape (n, 2)
        Column and row of each point.
    photo : ndarray of int, shape (n,), optional
        Photo that each point was taken from; a line joins points of one photo only.
    measured : ndarray of bool, shape (n,), optional
        Points whose distances are measured; the lines are fitted to all.

    Returns
    -------
    Straightness
        Over the orthogonal distances of all lines that have at least three points, one of them
        measured; not-a-number and 0 lines if there is none.
    """
    uv, index = np.asarray(uv, np.float64), np.asarray(index)
    photo = np.zeros(len(uv), int) if photo is None else np.asarray(photo)
    measured = np.ones(len(uv), bool) if measured is None else np.asarray(measured)
    distances, by_line = [], []
    for axis, name in enumerate(("column", "row")):
        keys = np.stack([photo, index[:, axis]], axis=1)
        names, line = np.unique(keys, axis=0, return_inverse=True)
        for number, key in enumerate(names):
            on = line.ravel() == number
            counts = measured[on]
            if on.sum() >= 3 and counts.any():
                centred = uv[on] - uv[on].mean(axis=0)
                normal = np.linalg.svd(centred, full_matrices=False)[2][1]
                off = np.abs(centred @ normal)[counts]
                distances.append(off)
                by_line.append({"photo": int(key[0]), name: int(key[1]), "points": len(off),
                                "rms_px": float(np.sqrt(np.mean(off**2))),
                                "max_px": float(off.max())})
    if not distances:
        return Straightness(float("nan"), float("nan"), 0, ())
    every = np.concatenate(distances)
    return Straightness(float(np.sqrt(np.mean(every**2))), float(every.max()), len(distances),
                        tuple(by_line))


def corrected_positions(back_map, corrected, distorted):
    """Positions (n, 2) of measured points in the picture that ``back_map`` corrects.

    ``corrected`` (n, 2) are the ideal positions, near which the linear part of the inverse map is
    sufficient.
    """
    def at(du, dv):
        return np.stack(back_map(corrected[:, 0] + du, corrected[:, 1] + dv), axis=1)
    change = np.stack([at(_STEP, 0) - at(-_STEP, 0), at(0, _STEP) - at(0, -_STEP)], axis=2)
    off = distorted - at(0, 0)
    return corrected + np.linalg.solve(change / (2 * _STEP), off[:, :, None])[:, :, 0]
