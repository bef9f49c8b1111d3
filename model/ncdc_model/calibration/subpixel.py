"""Sub-pixel positions of a board's corners, and the blur of their edges."""

import cv2
import numpy as np

from ncdc_model.calibration.sampling import bilinear

__all__ = ["by_edges", "edge_blur", "gaps", "refine"]

_SCALE = 1.0, 2.0      # pixels: smallest and largest Gaussian that a corner is found at
_PART = 0.09           # the same, in parts of the distance to the nearest corner
_FINE = 0.5            # pixels: smallest Gaussian where a marker is near
_OF_MARGIN = 0.2       # of the distance to the marker: largest Gaussian
_TWICE = 2.0           # times that scale: the second one
_APART = 0.5           # pixels between the positions at both: less means four equal squares
_SHARP = 3.0           # pixels of blur: less is sharp
_HALF = 5              # pixels to either side: largest window on a sharp corner's edges
_STOP = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
_STEPS = 8             # Newton iterations, at most, each of no more than a scale
_KERNEL = 4            # scales: reach of OpenCV's Gaussian
_RINGS = 0.35, 0.13    # of the distance to the nearest corner: radius at which edges are sampled;
                       # the second where markers lie in the squares
_SAMPLES = 96          # on the ring


def refine(grey, index, xy, scale, plain=None):
    """Saddle points of the brightness near first positions of corners.

    A corner looks the same after half a turn, however much it is blurred. So its position is the
    saddle of the smoothed brightness at every scale. A parabola is fitted to nine samples one scale
    apart, and moved to where it is level, until it stays. If the position at twice the scale is
    another, the squares are lit unevenly: then the edges determine a sharp corner's position.
    A corner without a saddle, or that moves by more than ``scale`` and a pixel, is not changed, or
    is not-a-number if ``plain`` is given.

    Parameters
    ----------
    grey : ndarray of uint8, shape (h, w)
    index, xy : ndarray, shape (n, 2)
        Column and row, and first positions.
    scale : float
        Blur in pixels at which the corners were found.
    plain : ndarray, shape (n,), optional
        Pixels around each corner within which there is nothing but its squares: a marker beyond
        must not enter the smoothed brightness. Default: the squares are plain.

    Returns
    -------
    ndarray, shape (n, 2)
    """
    if plain is None and len(xy) < 2:
        return xy
    lost = xy if plain is None else np.full_like(xy, np.nan, np.float64)
    if plain is None:
        near = gaps(index, xy)
        sigma, plain = np.clip(_PART * near, *_SCALE), near / 3
        other = _TWICE * sigma
    else:
        # A marker would enter the second scale, if it were the larger one.
        near = 3 * plain
        sigma = np.clip(_OF_MARGIN * plain, _FINE, _SCALE[1])
        other = np.maximum(sigma / _TWICE, _FINE)
    corner, light = _around(grey, xy, max(sigma.max(), other.max()))
    moved, found = _saddles(light, xy - corner, sigma)
    again, still = _saddles(light, moved, other)
    moved, again = moved + corner, again + corner
    # The four squares differ in a shadow or glare: use their edges, if they are sharp.
    apart = _APART * np.minimum(1, other / sigma)
    uneven = found & ~(still & (np.linalg.norm(again - moved, axis=1) < apart))
    if uneven.any():
        uneven[uneven] = ~(edge_blur(grey, xy[uneven], near[uneven]) >= _SHARP)
        moved[uneven] = by_edges(grey, xy[uneven], plain[uneven])
    good = found & (np.linalg.norm(moved - xy, axis=1) <= 1 + scale)
    return np.where(good[:, None], moved, lost)


def _around(grey, xy, scale):
    """First column and row of the part of ``grey`` that the search from ``xy`` (n, 2) at up to
    ``scale`` pixels can reach, and that part as float32."""
    reach = (2 * _STEPS + 1 + _KERNEL) * scale + 2
    first = np.maximum(np.floor(xy.min(axis=0) - reach), 0).astype(int)
    left, top = np.minimum(first, np.array(grey.shape[::-1]) - 1)
    right, bottom = np.ceil(xy.max(axis=0) + reach).astype(int) + 1
    return np.array([left, top]), grey[top:max(bottom, top + 1),
                                       left:max(right, left + 1)].astype(np.float32)


def by_edges(grey, xy, plain):
    """Positions (n, 2) of the corners by OpenCV's ``cornerSubPix``, which uses the edges.

    ``plain``: pixels (n,) to either side that hold nothing else.
    """
    moved, limit = xy.astype(np.float64).copy(), np.array(grey.shape[::-1])
    halves = np.clip(plain, 2, _HALF).astype(int)
    for half in np.unique(halves):
        inside = (halves == half) & ((xy > half + 1) & (xy < limit - half - 2)).all(axis=1)
        if inside.any():
            corners = xy[inside].astype(np.float32).reshape(-1, 1, 2).copy()
            moved[inside] = cv2.cornerSubPix(grey, corners, (int(half), int(half)), (-1, -1),
                                             _STOP).reshape(-1, 2)
    return moved


def _saddles(light, xy, sigma):
    """Positions (n, 2) of the saddles near ``xy`` (n, 2) of ``light`` smoothed by Gaussians of
    ``sigma`` (n,) pixels, and whether each exists (n,)."""
    i, j = (part.ravel() for part in np.meshgrid((-1.0, 0.0, 1.0), (-1.0, 0.0, 1.0)))
    fit = np.linalg.pinv(np.stack([np.ones(9), i, j, i * i, i * j, j * j], axis=1))
    position, found = xy.astype(np.float64).copy(), np.ones(len(xy), bool)
    # Quarter steps of the scale limit the number of smoothed pictures.
    level = np.rint(4 * sigma) / 4
    for scale in np.unique(level):
        on = level == scale
        smooth, at = cv2.GaussianBlur(light, (0, 0), scale), position[on]
        is_saddle = np.ones(len(at), bool)
        offset = scale * np.stack([i, j], axis=1)
        for _ in range(_STEPS):
            values = bilinear(smooth, at[:, None] + offset)
            _, gx, gy, xx, half, yy = (values @ fit.T).T
            det = 4 * xx * yy - half * half
            is_saddle &= det < 0
            safe = np.where(is_saddle, det, -1.0)
            move = np.stack([half * gy - 2 * yy * gx, half * gx - 2 * xx * gy], axis=1)
            move = move / safe[:, None]
            length = np.linalg.norm(move, axis=1, keepdims=True)
            at = at + np.where(is_saddle[:, None], scale * move / np.maximum(1, length), 0)
        position[on], found[on] = at, is_saddle
    return position, found


def edge_blur(grey, xy, gap):
    """Blur (n,), a Gaussian's sigma in pixels, of the softest of the four edges that meet at each
    of ``xy`` (n, 2), sampled on a ring; ``gap`` (n,): pixels to the nearest corner. Not-a-number
    where the ring does not change four times."""
    smooth = cv2.GaussianBlur(grey, (0, 0), 0.7)
    wide, narrow = (_blur_on_ring(smooth, xy, part * gap[:, None]) for part in _RINGS)
    return np.where(np.isfinite(wide), wide, narrow)


def _blur_on_ring(smooth, xy, radius):
    turns = 2 * np.pi * np.arange(_SAMPLES) / _SAMPLES
    at = xy[:, None] + radius[..., None] * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    ring = bilinear(smooth, at)
    low, high = np.percentile(ring, (10, 90), axis=1)
    bright = ring > ((low + high) / 2)[:, None]
    crossing = bright != np.roll(bright, 1, axis=1)
    slope = np.abs(np.roll(ring, -1, axis=1) - np.roll(ring, 1, axis=1)) / (
        4 * np.pi * radius / _SAMPLES)
    around = np.max([np.roll(slope, k, axis=1) for k in range(-4, 5)], axis=0)
    slopes = np.where(crossing, around, np.inf).min(axis=1)
    known = (crossing.sum(axis=1) == 4) & (slopes > 0)
    return np.where(known, (high - low) / np.sqrt(2 * np.pi) / np.where(known, slopes, 1), np.nan)


def gaps(index, xy):
    """Distance (n,) of each corner from the nearest of its neighbours on the lattice."""
    number_of = {tuple(key): k for k, key in enumerate(index.tolist())}
    near = np.full(len(xy), np.inf)
    for (i, j), k in number_of.items():
        for key in ((i + 1, j), (i, j + 1)):
            if key in number_of:
                other = number_of[key]
                far = np.linalg.norm(xy[other] - xy[k])
                near[k], near[other] = min(near[k], far), min(near[other], far)
    known = near[np.isfinite(near)]
    return np.where(np.isfinite(near), near, np.median(known) if len(known) else 12.0)
