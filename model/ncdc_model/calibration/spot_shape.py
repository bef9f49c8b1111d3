"""Tells whether the dark spots of a lattice are round or square, however they are seen."""

import numpy as np

from ncdc_model.calibration.sampling import bilinear

__all__ = ["are_square"]

_SAMPLES = 24          # across a cell of the lattice
_MOST = 120            # spots that are looked at
_FEWEST = 5            # spots
_SQUARE = 1.0          # of a square 2.4, of a disc 0: the fourth moment of the whitened spot
_PIXELS = 20.0         # of a spot: smaller ones are not judged
_WINDOW = 1.7          # times the side of a square of the spot's area: width of what is sampled


def are_square(picture, spots):
    """Whether the dark ``spots``, PhotoPoints with areas, are squares, seen from anywhere.

    Each spot is sampled in its own cell of the lattice, or the middle of it if it is small. It is
    moved, turned and stretched until its second moments are those of a round one. Then a disc has
    the fourth moment |mean((x + i y)^4)| = 0, and a square 2.4: perspective and lens change little
    of that.

    Parameters
    ----------
    picture : ndarray, shape (h, w)
        Grey, the spots dark.
    """
    index, xy = spots.index, spots.xy
    number_of = {tuple(key): k for k, key in enumerate(index.tolist())}
    part = (np.arange(_SAMPLES) + 0.5) / _SAMPLES - 0.5
    cell = np.stack(np.meshgrid(part, part), axis=-1).reshape(-1, 2)
    found = []
    for k in np.random.default_rng(1).permutation(len(index))[:_MOST]:
        i, j = index[k]
        steps = []
        for di, dj in ((1, 0), (0, 1)):
            ends = [number_of.get(key) for key in ((i - di, j - dj), (i, j), (i + di, j + dj))]
            ends = [xy[end] for end in ends if end is not None]
            if len(ends) > 1:
                steps.append((ends[-1] - ends[0]) / (len(ends) - 1))
        if len(steps) < 2 or spots.area[k] < _PIXELS:
            continue
        covered = spots.area[k] / max(abs(np.linalg.det(steps)), 1e-9)
        at = xy[k] + min(1.0, _WINDOW * np.sqrt(covered)) * cell @ np.array(steps)
        found.append(_fourth_moment(bilinear(picture, at), cell))
    found = [value for value in found if np.isfinite(value)]
    return len(found) >= _FEWEST and bool(np.median(found) > _SQUARE)


def _fourth_moment(values, cell):
    """|mean((x + i y)^4)| of what is darker than half in ``values`` (n,) at ``cell`` (n, 2),
    whitened; not-a-number without a spot."""
    low, high = np.percentile(values, (5, 95))
    spot = cell[values < (low + high) / 2]
    if len(spot) < 12:
        return np.nan
    spot = spot - spot.mean(axis=0)
    covariance = spot.T @ spot / len(spot)
    if np.linalg.det(covariance) < 1e-9:
        return np.nan
    white = spot @ np.linalg.cholesky(np.linalg.inv(covariance))
    return float(abs(np.mean((white @ (1, 1j))**4)))
