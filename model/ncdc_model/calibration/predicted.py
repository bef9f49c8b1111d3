"""Corners of a board that were missed, found where a smooth lens predicts them."""

import cv2
import numpy as np

from ncdc_model.calibration.corners import cornerlike
from ncdc_model.calibration.smooth import rough_lens
from ncdc_model.calibration.subpixel import refine

__all__ = ["completed", "plain_pixels"]

_ROUNDS = 6
_NEXT = 2              # columns and rows from a known corner, at most: farther ones wait a round
_EXPLAINED = 2.0       # pixels, median residual: a lens that leaves more predicts nothing
_SMALL = 1.5           # pixels around a corner that must be plain
_RING = 0.8            # of what is plain: radius at which a corner's surroundings are compared
_BLUR = 0.7            # pixels
_STEP = 0.05           # of a unit: for the scale of the picture


def completed(grey, known, wanted, places, plain):
    """Index (n, 2) and pixels (n, 2) of the ``known`` corners and of the others that are found.

    A lens is fitted to the known corners. A corner of the board that is next to them is searched
    for where the lens predicts it. It counts if it lies within the plain squares there and looks
    like a corner. The lens is fitted again, until no more are found.

    Parameters
    ----------
    grey : ndarray of uint8, shape (h, w)
    known : (ndarray, ndarray)
        Index (n, 2) and pixels (n, 2).
    wanted : ndarray of int, shape (m, 2)
        Index of all corners of the board.
    places : callable
        Places (k, 2) on the board of an index (k, 2), in any unit.
    plain : float
        Units around a corner within which there is nothing but its squares.
    """
    index, xy = known
    size, smooth = np.array(grey.shape[::-1]), cv2.GaussianBlur(grey, (0, 0), _BLUR)
    for _ in range(_ROUNDS):
        fit = rough_lens(grey.shape[::-1], places(index), xy, _EXPLAINED)
        there = set(map(tuple, index.tolist()))
        more = np.array([key for key in wanted.tolist() if tuple(key) not in there
                         ], int).reshape(-1, 2)
        if fit is None or not len(more):
            break
        far = np.abs(more[:, None] - index).max(axis=2).min(axis=1)
        at, around = fit.pixels(0, places(more)), plain_pixels(fit, places(more), plain)
        near = (far <= _NEXT) & (around >= _SMALL) & ((at > around[:, None])
                                                      & (at < size - 1 - around[:, None])
                                                      ).all(axis=1)
        more, at, around = more[near], at[near], around[near]
        if not len(more):
            break
        moved = refine(grey, more, at, around.max(), around)
        found = np.linalg.norm(moved - at, axis=1) < np.maximum(around, _SMALL)
        found &= cornerlike(smooth, moved, _RING * around)
        if not found.any():
            break
        index, xy = np.vstack([index, more[found]]), np.vstack([xy, moved[found]])
    return index, xy


def plain_pixels(fit, places, plain):
    """Pixels (n,), in the direction in which they are fewest, of ``plain`` units at ``places``."""
    across, down = ((fit.pixels(0, places + step) - fit.pixels(0, places - step)) / (2 * _STEP)
                    for step in ((_STEP, 0), (0, _STEP)))
    scale = np.linalg.svd(np.nan_to_num(np.stack([across, down], axis=2)), compute_uv=False)[:, 1]
    return plain * scale
