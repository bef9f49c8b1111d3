"""Holds the picture of each dot against those of the dots around it: of a dot that something
touches or half covers, the centroid of what is dark is not the centre."""

import warnings

import cv2
import numpy as np

from ncdc_model.calibration.blobs import flat_field
from ncdc_model.calibration.neighbours import displaced, neighbours
from ncdc_model.calibration.sampling import sample

__all__ = ["alike"]

_SECTORS = 16          # directions from a dot's centre
_INNER = 0.6           # of the radius: the inner ring
_BEYOND = 2.0          # pixels around a blob that still hold some of its ink
_SIGMAS = 3.0          # times the usual difference: more is another picture
_FLOOR = 0.35          # of a dot's contrast, that it may differ in any case
# Pixels and parts of a step from its prediction: a dot that looks odd but is nearer is right.
_MOVED = 0.35, 0.012
_LEAST = 3             # neighbours that tell how a dot looks
_BLOCK = 1 << 10       # dots at a time, which bounds the memory
REASON = "touched or partly covered: it looks otherwise than the dots around it"


def alike(image, photo):
    """``photo``, PhotoPoints on a lattice, without dots that look otherwise than their neighbours.

    Each dot is seen along rings inside it, on its edge and just outside, in the directions of the
    lattice's own steps, so that tilt and lens do not matter, and in units of its own contrast. The
    usual picture is the median of up to 24 neighbours'. A dot is dropped if the difference,
    averaged over a quarter turn of one ring, is more than three times what is usual and
    more than 0.35 of its contrast, both times sqrt(1 + 3 / neighbours), and its neighbours predict
    it elsewhere by more than 0.35 pixels and 1.2 % of a step.
    """
    if len(photo.index) < 9:
        return photo
    near = neighbours(photo.index)
    score = difference(image, photo, near)
    # Few neighbours tell less well how a dot should look.
    wider = np.sqrt(1 + 3 / np.maximum((near >= 0).sum(axis=1), 1))
    wrong = score > max(_FLOOR, _SIGMAS * float(np.median(score))) * wider
    # Half in the shade a dot looks odd, but is where it should be.
    step = np.linalg.norm(_steps(photo, near), axis=2).min(axis=0)
    wrong &= displaced(photo.index, photo.xy) > np.maximum(_MOVED[0], _MOVED[1] * step)
    return photo.without(wrong, REASON)


def difference(image, photo, near):
    """By how much (n,) of its contrast each dot differs from the usual picture around it, in the
    quarter turn where it differs most."""
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
    told = there.sum(axis=1) >= _LEAST
    usual = np.zeros_like(seen[part])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)    # all neighbours beyond the border
        usual[told] = np.nanmedian(around[told], axis=1)
    off = np.where(told[:, None, None], np.nan_to_num(seen[part] - usual), 0)
    wide = sum(np.roll(off, k, axis=2) for k in range(_SECTORS // 4)) / (_SECTORS // 4)
    return np.abs(wide).max(axis=(1, 2))


def _pictures(flat, xy, area, across, down):
    """Depth (n, rings, sectors) below the page, in parts of each dot's own; not-a-number beyond the
    photo's border. ``across`` and ``down`` are the steps (n, 2) of the lattice."""
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
    places = xy[:, None, None] + rings[..., None] * way[:, None]
    bright = sample(flat, places)
    page = np.median(bright[:, -1], axis=1)
    depth = np.maximum(page - sample(flat, xy), 0.02)
    seen = (page[:, None, None] - bright) / depth[:, None, None]
    inside = ((places >= 0) & (places <= np.array(flat.shape[::-1]) - 1)).all(axis=-1)
    return np.where(inside, seen, np.nan)


def _steps(photo, near):
    """Steps (n, 2) to the next column and row, by least squares over each point's neighbours."""
    there = near >= 0
    index = np.where(there[:, :, None], photo.index[near] - photo.index[:, None], 0).astype(float)
    offset = np.where(there[:, :, None], photo.xy[near] - photo.xy[:, None], 0)
    # The nearest count most: farther off the lens has changed the step.
    weight = 1 / np.maximum((index**2).sum(axis=2), 1)**3
    square = np.einsum("nk,nki,nkj->nij", weight, index, index)
    mixed = np.einsum("nk,nki,nkj->nij", weight, index, offset)
    flat = np.abs(np.linalg.det(square)) < 0.01
    square[flat] = np.eye(2)
    steps = np.linalg.solve(square, mixed)
    steps[flat] = np.median(steps[~flat], axis=0) if not flat.all() else 0
    return steps[:, 0], steps[:, 1]
