"""How straight a flat target's rows and columns are in the corrected picture."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Straightness", "straightness"]


@dataclass(frozen=True)
class Straightness:
    """Distances, in pixels, of points from the straight lines fitted to their rows and columns."""
    rms: float
    max: float
    lines: int


def straightness(uv, index, photo=None):
    """Fit a line to every row and column of a flat target.

    Parameters
    ----------
    uv : ndarray, shape (n, 2)
        The target's points in the corrected picture (or any other), in pixels.
    index : ndarray of int, shape (n, 2)
        Column and row of each point.
    photo : ndarray of int, shape (n,), optional
        Photo that each point was taken from; a line joins points of one photo only.

    Returns
    -------
    Straightness
        Over the orthogonal distances of all lines that have at least three points; not-a-number
        and 0 lines if there is none.
    """
    uv, index = np.asarray(uv, np.float64), np.asarray(index)
    photo = np.zeros(len(uv), int) if photo is None else np.asarray(photo)
    distances = []
    for axis in (0, 1):
        keys = np.stack([photo, index[:, axis]], axis=1)
        _, line = np.unique(keys, axis=0, return_inverse=True)
        for number in range(line.max(initial=-1) + 1):
            points = uv[line.ravel() == number]
            if len(points) >= 3:
                centred = points - points.mean(axis=0)
                normal = np.linalg.svd(centred, full_matrices=False)[2][1]
                distances.append(np.abs(centred @ normal))
    if not distances:
        return Straightness(float("nan"), float("nan"), 0)
    every = np.concatenate(distances)
    return Straightness(float(np.sqrt(np.mean(every**2))), float(every.max()), len(distances))
