"""Sub-pixel places of a board's corners, and the blur of their edges."""

import cv2
import numpy as np
from scipy.ndimage import map_coordinates

__all__ = ["edge_blur", "gaps", "refine"]

_SCALE = 1.0, 2.0      # pixels: Gaussian that a corner's place is found at, from and to
_PART = 0.09           # of the way to the nearest corner: the same
_TWICE = 2.0           # times that scale: the second one
_APART = 0.5           # pixels between the places at both: less is a corner of four equal squares
_SHARP = 3.0           # pixels of blur: less is sharp
_HALF = 5              # pixels to either side that a sharp corner's edges are seen in, at most
_STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
_STEPS = 8             # of Newton, at most
_RINGS = 0.35, 0.13    # of the way to the nearest corner: radius at which edges are looked at;
                       # the second where markers lie in the squares
_SAMPLES = 96          # on the ring


def refine(grey, index, xy, scale):
    """Saddle points of the brightness next to first places of corners.

    At half of a turn a corner looks like itself, however much it is blurred: so the saddle of the
    smoothed brightness is its place, at every scale. A parabola is fitted to nine places one scale
    apart, and moved to where it is level, until it stays. Where the place at twice the scale is
    another, the squares are lit unevenly: there a sharp corner is where its edges point. A
    corner that moves by more than ``scale`` and a pixel, or has no saddle, keeps its first place.

    Parameters
    ----------
    grey : ndarray of uint8, shape (h, w)
    index, xy : ndarray, shape (n, 2)
        Column and row, and first places.
    scale : float
        Blur in pixels at which the corners were found.

    Returns
    -------
    ndarray, shape (n, 2)
    """
    if len(xy) < 2:
        return xy
    near = gaps(index, xy)
    sigma = np.clip(_PART * near, *_SCALE)
    light = grey.astype(np.float32)
    moved, found = _saddles(light, xy, sigma)
    again, still = _saddles(light, moved, _TWICE * sigma)
    # In a shadow or glare the four squares differ: their edges tell better, if they are sharp.
    uneven = found & ~(still & (np.linalg.norm(again - moved, axis=1) < _APART))
    if uneven.any():
        uneven[uneven] = ~(edge_blur(grey, xy[uneven], near[uneven]) >= _SHARP)
        moved[uneven] = _by_edges(grey, xy[uneven], near[uneven])
    good = found & (np.linalg.norm(moved - xy, axis=1) <= 1 + scale)
    return np.where(good[:, None], moved, xy)


def _by_edges(grey, xy, near):
    """Places (n, 2) past which the brightness' gradient points all around."""
    moved, limit = xy.astype(np.float64).copy(), np.array(grey.shape[::-1])
    half = int(np.clip(near.min() / 3, 2, _HALF)) if len(near) else 2
    inside = ((xy > half + 1) & (xy < limit - half - 2)).all(axis=1)
    if inside.any():
        corners = xy[inside].astype(np.float32).reshape(-1, 1, 2).copy()
        moved[inside] = cv2.cornerSubPix(grey, corners, (half, half), (-1, -1),
                                         _STOP).reshape(-1, 2)
    return moved


def _saddles(light, xy, sigma):
    """Places (n, 2) of the saddles near ``xy`` (n, 2) of ``light`` smoothed by Gaussians of
    ``sigma`` (n,) pixels, and whether there is one each (n,)."""
    i, j = (part.ravel() for part in np.meshgrid((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)))
    fit = np.linalg.pinv(np.stack([np.ones(9), i, j, i * i, i * j, j * j], axis=1))
    place, found = xy.astype(np.float64).copy(), np.ones(len(xy), bool)
    # Quarter steps of the scale, so that few pictures are smoothed.
    level = np.maximum(np.rint(4 * sigma), 4) / 4
    for scale in np.unique(level):
        on = level == scale
        smooth, at = cv2.GaussianBlur(light, (0, 0), scale), place[on]
        is_saddle = np.ones(len(at), bool)
        offset = scale * np.stack([i, j], axis=1)
        for _ in range(_STEPS):
            spots = at[:, None] + offset
            values = map_coordinates(smooth, [spots[..., 1], spots[..., 0]], order=1,
                                     mode="nearest")
            _, gx, gy, xx, half, yy = (values @ fit.T).T
            det = 4 * xx * yy - half * half
            is_saddle &= det < 0
            safe = np.where(is_saddle, det, -1.0)
            move = np.stack([half * gy - 2 * yy * gx, half * gx - 2 * xx * gy], axis=1)
            move = move / safe[:, None]
            length = np.linalg.norm(move, axis=1, keepdims=True)
            at = at + np.where(is_saddle[:, None], scale * move / np.maximum(1, length), 0)
        place[on], found[on] = at, is_saddle
    return place, found


def edge_blur(grey, xy, gap):
    """Blur (n,), a Gaussian's sigma in pixels, of the softest of the four edges that meet at each
    of ``xy`` (n, 2), seen on a ring; ``gap`` (n,): pixels to the nearest corner. Not-a-number where
    the ring does not change four times."""
    smooth = cv2.GaussianBlur(grey, (0, 0), 0.7)
    wide, narrow = (_blur_on_ring(smooth, xy, part * gap[:, None]) for part in _RINGS)
    return np.where(np.isfinite(wide), wide, narrow)


def _blur_on_ring(smooth, xy, radius):
    turns = 2 * np.pi * np.arange(_SAMPLES) / _SAMPLES
    at = xy[:, None] + radius[..., None] * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    ring = map_coordinates(smooth, [at[..., 1], at[..., 0]], output=np.float32, order=1,
                           mode="nearest")
    low, high = np.percentile(ring, (10, 90), axis=1)
    bright = ring > ((low + high) / 2)[:, None]
    crossing = bright != np.roll(bright, 1, axis=1)
    slope = np.abs(np.roll(ring, -1, axis=1) - np.roll(ring, 1, axis=1)) / (
        4 * np.pi * radius / _SAMPLES)
    around = np.max([np.roll(slope, k, axis=1) for k in range(-4, 5)], axis=0)
    slopes = np.where(crossing, around, np.inf).min(axis=1)
    told = (crossing.sum(axis=1) == 4) & (slopes > 0)
    return np.where(told, (high - low) / np.sqrt(2 * np.pi) / np.where(told, slopes, 1), np.nan)


def gaps(index, xy):
    """Distance (n,) of each corner from the nearest of its neighbours on the lattice."""
    place = {tuple(key): k for k, key in enumerate(index.tolist())}
    near = np.full(len(xy), np.inf)
    for (i, j), k in place.items():
        for key in ((i + 1, j), (i, j + 1)):
            if key in place:
                far = np.linalg.norm(xy[place[key]] - xy[k])
                near[k], near[place[key]] = min(near[k], far), min(near[place[key]], far)
    known = near[np.isfinite(near)]
    return np.where(np.isfinite(near), near, np.median(known) if len(known) else 12.0)
