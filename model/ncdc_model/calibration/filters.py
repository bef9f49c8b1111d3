"""The colour filter of a raw frame: its green sites, and how far red and blue lie beside them."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.calibration.subpixel import gaps, refine
from ncdc_spec.geometry import BAYER_PHASE

__all__ = ["LateralColour", "Shifts", "filter_seen", "green_picture", "lateral_colour", "parts_of",
           "pattern_of", "shifts_of"]

_CAST = 0.03           # logarithm of brightness by which two colours of the filter differ
_SAME = 0.25           # times that: sites of one colour differ by less
_BLOCK = 16            # pixels of the blocks whose brightness is compared
_POINTS = 200          # of a photo, at which the colours are compared
_HALF = 16             # pixels to either side of a corner that are looked at
_WIDEST = 60           # the same, of a dot
_PLAIN = 5.0, 10.0     # pixels around a corner: smaller ones hold too few sites of a colour
_LARGEST = 6.0         # pixels: a larger shift is a wrong one
_FEWEST = 12           # points
_SURE = 5.0            # standard errors: two sites of the filter have different colours
_LEAST = 0.05          # pixels in the picture's corner: a smaller difference moves no point
_KERNELS = {"green": np.array([[0, 1, 0], [1, 4, 1], [0, 1, 0]], np.float32) / 4,
            "other": np.array([[1, 2, 1], [2, 4, 2], [1, 2, 1]], np.float32) / 4}
_SITES = (0, 0), (1, 0), (0, 1), (1, 1)        # column and row within the filter's square


@dataclass(frozen=True)
class LateralColour:
    """Pixels by which red and blue lie farther from the middle than green in the picture's corner,
    with their standard errors, the number of points compared, and the pixels by which either is
    shifted as a whole."""
    red: float
    red_error: float
    blue: float
    blue_error: float
    points: int
    shift: float

    @property
    def moves(self):
        """Whether red or blue lies elsewhere than green by so much that it moves points."""
        return max(abs(self.red), abs(self.blue), self.shift) > _LEAST


@dataclass(frozen=True)
class Shifts:
    """Positions ``xy`` (n, 2) of points of one photo of a ``size``, and those that each part of the
    sites shows instead, ``seen`` (parts, n, 2)."""
    size: tuple
    xy: np.ndarray
    seen: np.ndarray


def pattern_of(raw):
    """Filter pattern of a raw frame by its colour cast; None if its sites are equally bright.

    Black and white look grey, so that the sites of one colour are equally bright, and those of
    another colour are not, unless the light and the sensor happen to be balanced. If red is as
    bright as blue, the brighter sites are the green ones.
    """
    height, width = (side // 2 for side in raw.shape)
    blocks = max(1, width * 2 // _BLOCK), max(1, height * 2 // _BLOCK)
    level = {site: np.log(cv2.resize(np.ascontiguousarray(raw[site[1]::2, site[0]::2])
                                     [:height, :width].astype(np.float32) + 1, blocks,
                                     interpolation=cv2.INTER_AREA)) for site in _SITES}

    def apart(first, second):
        return float(np.median(level[first] - level[second]))
    one, two = apart((0, 0), (1, 1)), apart((1, 0), (0, 1))
    between = apart((1, 0), (0, 0)) + apart((0, 1), (1, 1))
    if max(abs(one), abs(two)) > _CAST:
        if min(abs(one), abs(two)) > _SAME * max(abs(one), abs(two)):
            return None
        return "RGGB" if abs(one) > abs(two) else "GRBG"
    if abs(between) > 2 * _CAST:
        return "RGGB" if between > 0 else "GRBG"
    return None


def green_picture(raw, pattern):
    """Grey uint8 picture of the green sites; at the others it is the mean of the four around."""
    return np.rint(_plane(raw, _sites(pattern)["green"], "green")).astype(np.uint8)


def _sites(pattern):
    """Column and row of the sites of each colour within the filter's square."""
    column, row = BAYER_PHASE[pattern]
    return {"red": [(column, row)], "blue": [(1 - column, 1 - row)],
            "green": [(1 - column, row), (column, 1 - row)]}


def _plane(raw, sites, kernel):
    """float32 picture of the ``sites`` of a raw frame, the others interpolated."""
    plane = np.zeros(raw.shape, np.float32)
    for column, row in sites:
        plane[row::2, column::2] = raw[row::2, column::2]
    return cv2.filter2D(plane, -1, _KERNELS[kernel])


def shifts_of(raw, photo, parts):
    """:class:`Shifts` of some of the points of PhotoPoints ``photo`` of a ``raw`` frame.

    ``parts``: sequence of lists of sites, as column and row within the filter's square.
    """
    size, whole = raw.shape[1::-1], photo.whole
    chosen = np.random.default_rng(1).permutation(len(whole.index))[:_POINTS]
    xy, dots = whole.xy[chosen], bool(whole.area.any())
    if dots:
        radius = np.sqrt(whole.area[chosen] / np.pi)
        half = int(np.clip(np.ceil(1.6 * np.median(radius)) + 3, 6, _WIDEST))
    else:
        plain, half = np.clip(0.3 * gaps(whole.index, whole.xy)[chosen], *_PLAIN), _HALF
    # Each patch begins at an even column and row: it has the filter of the frame.
    first = np.floor((xy - half) / 2).astype(int) * 2
    side = 2 * half + 2
    inside = ((first >= 0) & (first + side <= size)).all(axis=1)
    xy, first = xy[inside], first[inside]
    if not len(xy):
        return Shifts(size, xy, np.empty((len(parts), 0, 2)))
    stack = np.vstack([raw[y:y + side, x:x + side] for x, y in first])
    offset = np.stack([np.zeros(len(xy)), side * np.arange(len(xy))], axis=1) - first
    seen = []
    for sites in parts:
        plane = _plane(stack, sites, "green" if len(sites) == 2 else "other")
        if dots:
            at = _centroids(plane.reshape(-1, side, side), xy - first, radius[inside])
            seen.append(at + first)
        else:
            here = xy + offset
            seen.append(refine(plane, np.zeros((len(xy), 2), int), here, _LARGEST,
                               plain[inside]) - offset)
    return Shifts(size, xy, np.array(seen))


def _centroids(patches, middle, radius):
    """Centres of gravity (n, 2) of the dark dots of ``radius`` (n,) near ``middle`` in patches."""
    row, column = np.indices(patches.shape[1:])
    low, high = np.percentile(patches.reshape(len(patches), -1), (5, 85), axis=1)[:, :, None, None]
    ink = np.clip((high - patches) / np.maximum(high - low, 1) - 0.15, 0, 1)
    at = middle.copy()
    for _ in range(4):
        far = np.hypot(column - at[:, 0, None, None], row - at[:, 1, None, None])
        weight = ink * np.clip(1.5 * radius[:, None, None] + 1 - far, 0, 1)
        total = np.maximum(weight.sum(axis=(1, 2)), 1e-9)
        at = np.stack([(weight * part).sum(axis=(1, 2)) / total for part in (column, row)], axis=1)
    return at


def _growth(shifts, one, other):
    """By how many pixels the points of part ``one`` lie farther out than those of the ``other`` in
    the corner, its standard error, the number of points, and the pixels by which all are shifted;
    the error is infinite without points."""
    radius, moved, shift = [], [], []
    for photo in shifts:
        middle = (np.array(photo.size) - 1) / 2
        apart = photo.seen[one] - photo.seen[other]
        good = np.linalg.norm(apart, axis=1) < _LARGEST
        radius.append((photo.xy - middle)[good] / np.linalg.norm(middle))
        usual = np.median(apart[good], axis=0) if good.any() else np.zeros(2)
        moved.append(apart[good] - usual)
        shift.append(usual)
    radius, moved = np.concatenate(radius), np.concatenate(moved)
    keep = np.ones(len(radius), bool)
    for _ in range(3):
        if keep.sum() < _FEWEST:
            return 0.0, np.inf, 0, 0.0
        # The median shift was taken off: so is the mean position.
        out = radius - radius[keep].mean(axis=0)
        power = (out[keep]**2).sum()
        growth = float((out[keep] * moved[keep]).sum() / power)
        off = np.linalg.norm(moved - growth * out, axis=1)
        usual = float(np.median(off[keep])) / 1.1774
        keep = off < 4 * max(usual, 1e-3)
    return (growth, max(usual, 1e-3) / float(np.sqrt(power)), int(keep.sum()),
            float(np.linalg.norm(np.median(shift, axis=0))))


def lateral_colour(shifts):
    """:class:`LateralColour` of a sequence of :class:`Shifts` of red, green and blue; None without
    enough points."""
    red, blue = (_growth(shifts, part, 1) for part in (0, 2))
    if not (np.isfinite(red[1]) and np.isfinite(blue[1])):
        return None
    return LateralColour(*red[:2], *blue[:2], min(red[2], blue[2]), max(red[3], blue[3]))


def filter_seen(shifts):
    """Filter pattern of raw frames whose sites are equally bright, by lateral colour; None if the
    sites show the points at the same places.

    ``shifts``: of the four sites of the filter's square. The green sites, which lie on one
    diagonal, agree; red or blue does not.
    """
    def differ(one, other):
        growth, error, *_ = _growth(shifts, one, other)
        return abs(growth) / error if abs(growth) > _LEAST else 0.0
    falling, rising = differ(0, 3), differ(1, 2)
    if max(falling, rising) > _SURE:
        if min(falling, rising) > _SURE:
            return None
        return "RGGB" if falling > rising else "GRBG"
    return "RGGB" if min(differ(0, 1), differ(3, 2), differ(0, 2), differ(3, 1)) > _SURE else None


def parts_of(pattern=None):
    """Sites of red, green and blue of a pattern, or all four sites alone."""
    if pattern is None:
        return [[site] for site in _SITES]
    sites = _sites(pattern)
    return [sites["red"], sites["green"], sites["blue"]]
