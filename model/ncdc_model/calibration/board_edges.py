"""Checks a lattice of corners by the edges between them, and reads it along the squares."""

import numpy as np

from ncdc_model.calibration.sampling import bilinear

__all__ = ["are_squares", "on_edges", "readings"]

_ALONG = np.array([0.2, 0.35, 0.5, 0.65, 0.8])    # of the way from one corner to the next
_ASIDE = 0.1           # of that way: to either side of the edge
_CONTRAST = 0.3        # of the usual difference of both sides
_SEEN = 4              # of the five samples on an edge
_GOOD = 0.5            # of a corner's edges
_INSET = 0.12          # of a square, from its corners: where a circle does not reach
_FILLED = 0.8          # of these samples must be as dark or bright as the middle of their square


def readings():
    """Matrices (2, 2) that may turn the steps of a lattice into those along the squares: steps to
    the nearest corners may be diagonals on a board seen from a flat angle."""
    yield np.eye(2, dtype=int)
    for shear in (1, -1, 2, -2):
        yield np.array([[1, shear], [0, 1]])
        yield np.array([[1, 0], [shear, 1]])


def are_squares(picture, index, xy):
    """Whether the cells of a lattice ``index``, ``xy`` (n, 2) alternate between dark and bright up
    to their corners: circles that touch alternate too, but are round."""
    position = {tuple(key): point for key, point in zip(index.tolist(), xy)}
    spots, signs = [], []
    for i, j in position:
        cell = [position.get(key) for key in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
        if all(corner is not None for corner in cell):
            middle = sum(cell) / 4
            spots.append([middle, *(middle + (1 - 2 * _INSET) * (corner - middle)
                                    for corner in cell)])
            signs.append(1 if (i + j) % 2 else -1)
    if len(set(signs)) < 2:
        return False
    spots, signs = np.array(spots), np.array(signs)
    values = bilinear(picture, spots)
    bright, dark = (np.median(values[signs == sign, 0]) for sign in (1, -1))
    side = (values - (bright + dark) / 2) * signs[:, None] * np.sign(bright - dark)
    return bool((side[:, 1:] > 0).mean() >= _FILLED)


def on_edges(picture, index, xy):
    """Which corners (n,) have edges between black and white towards the corners next to them.

    The brightness on both sides of each edge is compared at five positions. An edge is good if at
    least four differ in the right direction by 0.3 of the usual difference. A corner needs at
    least half of its edges good.

    Parameters
    ----------
    picture : ndarray
        Grey.
    index, xy : ndarray, shape (n, 2)
    """
    number_of = {tuple(key): k for k, key in enumerate(index.tolist())}
    pairs = np.array([(k, number_of[key], axis) for (i, j), k in number_of.items()
                      for axis, key in enumerate(((i + 1, j), (i, j + 1))) if key in number_of]
                     ).reshape(-1, 3)
    if not len(pairs):
        return np.zeros(len(xy), bool)
    first, second, axis = pairs.T
    step = xy[second] - xy[first]
    aside = _ASIDE * np.stack([-step[:, 1], step[:, 0]], axis=1)
    along = xy[first] + _ALONG[:, None, None] * step
    ends = [bilinear(picture, at) for at in (along + aside, along - aside)]
    # The black side changes from edge to edge, and from columns to rows.
    sign = np.where((index[first].sum(axis=1) + axis) % 2, 1, -1)
    differ = (ends[0] - ends[1]) * sign
    if np.median(differ) < 0:
        differ = -differ
    good = (differ > _CONTRAST * np.median(differ)).sum(axis=0) >= _SEEN
    every, right = np.zeros(len(xy)), np.zeros(len(xy))
    for end in (first, second):
        np.add.at(every, end, 1)
        np.add.at(right, end, good)
    return (every > 0) & (right >= _GOOD * every) & (right > 0)
