"""Compares the image patch of each dot with those of its neighbours.

The centroid of a dot that something touches or half covers is not the dot's centre.
"""

import cv2
import numpy as np

from ncdc_model.calibration.blobs import flat_field
from ncdc_model.calibration.median import known_median
from ncdc_model.calibration.neighbours import displaced, neighbours
from ncdc_model.calibration.sampling import sample

__all__ = ["consistent_patches"]

_SECTORS = 16          # directions from a dot's centre
_INNER = 0.6           # of the radius: the inner ring
_BEYOND = 2.0          # pixels around a blob that still hold some of its ink
_SIGMAS = 3.0          # times the usual difference: a patch that differs by more is inconsistent
_FLOOR = 0.35          # of a dot's contrast, a difference that is allowed in any case
# Pixels and parts of a step from its prediction: an odd dot that is nearer is correct.
_MOVED = 0.35, 0.012
_MIN_NEIGHBOURS = 3             # that a usual patch is computed from
_BLOCK = 1 << 10       # dots at a time: bounds the memory
REASON = "touched or partly covered: it looks otherwise than the dots around it"


def consistent_patches(image, photo):
    """``photo``, PhotoPoints on a lattice, without dots that look otherwise than their neighbours.

    A patch samples a dot along rings inside it, on its edge and just outside. The directions are
    those of the lattice's steps, so that tilt and lens do not matter; the unit is the dot's own
    contrast. The usual patch is the median of up to 24 neighbours'. A dot is dropped if both hold:

    - its difference, averaged over a quarter turn of one ring, is more than three times the usual
      one and 0.35 of its contrast, both times sqrt(1 + 3 / neighbours);
    - it lies more than 0.35 pixels and 1.2 % of a step from where its neighbours predict it.
    """
    if len(photo.index) < 9:
        return photo
    near = neighbours(photo.index)
    score = difference(image, photo, near)
    # A usual patch of few neighbours is less certain.
    wider = np.sqrt(1 + 3 / np.maximum((near >= 0).sum(axis=1), 1))
    wrong = score > max(_FLOOR, _SIGMAS * float(np.median(score))) * wider
    # A dot that is half in the shade looks odd, but its position is correct.
    step = np.linalg.norm(_steps(photo, near), axis=2).min(axis=0)
    wrong &= displaced(photo.index, photo.xy) > np.maximum(_MOVED[0], _MOVED[1] * step)
    return photo.without(wrong, REASON)


def difference(image, photo, near):
    """Difference (n,) of each dot from the usual patch around it, in parts of its contrast.

    It is that of the quarter turn in which the two differ most.
    """
    flat = cv2.GaussianBlur(flat_field(image), (0, 0), 0.7)
    steps, blocks = _steps(photo, near), _blocks(len(near))
    seen = np.concatenate([_pictures(flat, photo.xy[part], photo.area[part],
                                     *(step[part] for step in steps)) for part in blocks])
    return np.concatenate([_differs(seen, part, near[part]) for part in blocks])


def _blocks(count):
    return [slice(start, start + _BLOCK) for start in range(0, count, _BLOCK)]


def _differs(seen, part, near):
    """:func:`difference` of the dots ``part``, a slice, whose neighbours are ``near``."""
    there = near >= 0
    around = np.where(there[:, :, None, None], seen[near], np.nan)
    known = there.sum(axis=1) >= _MIN_NEIGHBOURS
    usual = np.zeros_like(seen[part])
    usual[known] = known_median(around[known])
    off = np.where(known[:, None, None], np.nan_to_num(seen[part] - usual), 0)
    wide = sum(np.roll(off, k, axis=2) for k in range(_SECTORS // 4)) / (_SECTORS // 4)
    return np.abs(wide).max(axis=(1, 2))


def _pictures(flat, xy, area, across, down):
    """Depth (n, rings, sectors) below the page's brightness, in parts of each dot's own depth.

    It is not-a-number beyond the photo's border. ``across``, ``down``: the lattice's steps (n, 2).
    """
    cell = np.abs(across[:, 0] * down[:, 1] - across[:, 1] * down[:, 0])
    radius = np.sqrt(area / np.maximum(cell, 1e-9) / np.pi)
    angle = 2 * np.pi * np.arange(_SECTORS) / _SECTORS
    way = (np.cos(angle)[None, :, None] * across[:, None]
           + np.sin(angle)[None, :, None] * down[:, None])
    pixels = np.linalg.norm(way, axis=2)
    # The outer ring must not reach the next dot.
    outer = np.minimum(radius[:, None] + _BEYOND / np.maximum(pixels, 1e-6), 0.5)
    rings = np.stack([_INNER * radius[:, None] + 0 * outer, radius[:, None] + 0 * outer, outer],
                     axis=1)
    positions = xy[:, None, None] + rings[..., None] * way[:, None]
    bright = sample(flat, positions)
    page = np.median(bright[:, -1], axis=1)
    depth = np.maximum(page - sample(flat, xy), 0.02)
    seen = (page[:, None, None] - bright) / depth[:, None, None]
    inside = ((positions >= 0) & (positions <= np.array(flat.shape[::-1]) - 1)).all(axis=-1)
    return np.where(inside, seen, np.nan)


def _steps(photo, near):
    """Steps (n, 2) to the next column and row, by least squares over each point's neighbours."""
    there = near >= 0
    index = np.where(there[:, :, None], photo.index[near] - photo.index[:, None], 0).astype(float)
    offset = np.where(there[:, :, None], photo.xy[near] - photo.xy[:, None], 0)
    # Near ones have the largest weights: farther away the lens has changed the step.
    weight = 1 / np.maximum((index**2).sum(axis=2), 1)**3
    square = np.einsum("nk,nki,nkj->nij", weight, index, index)
    mixed = np.einsum("nk,nki,nkj->nij", weight, index, offset)
    flat = np.abs(np.linalg.det(square)) < 0.01
    square[flat] = np.eye(2)
    steps = np.linalg.solve(square, mixed)
    steps[flat] = np.median(steps[~flat], axis=0) if not flat.all() else 0
    return steps[:, 0], steps[:, 1]
