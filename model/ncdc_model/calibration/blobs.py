"""Dark blobs on a bright page: flat field, threshold, sub-pixel centres."""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.nearest import Nearest

__all__ = ["Blobs", "find_blobs", "flat_field"]

_SMALL = 5             # pixels
_FAINT = 0.25          # of the median contrast of the page: less is noise, not a dot
_DARK = 0.15           # of a dot's contrast: a pixel with less does not count as ink
_MARGIN = 2               # pixels around a blob that still hold some of its ink
_FILL = (0.80, 1.15)   # ratio of the area to that of the ellipse with the same second moments
_STRIP = 1 << 18       # pixels at a time: bounds the memory


@dataclass(frozen=True)
class Blobs:
    """Round blobs, and counts of rejected ones.

    Parameters
    ----------
    xy, area : ndarray, shapes (n, 2) and (n,)
        Centres, and areas in square pixels.
    rejected : dict
        Number of rejected blobs, by reason; those cut by the border are not included.
    cut : ndarray, shape (k, 2)
        Middles of the visible parts of blobs that the border cuts.
    """
    xy: np.ndarray
    area: np.ndarray
    rejected: dict
    cut: np.ndarray


def flat_field(image):
    """Brightness of ``image`` relative to its surroundings, float32, about 1 on average.

    The divisor is a Gaussian a sixteenth of the image wide. A single-channel image is divided
    separately for each of the four positions of a colour filter. So a raw frame of a black and
    white target becomes grey without interpolation, and a grey image does not change.
    """
    if image.ndim == 3:
        return _relative(cv2.cvtColor(image, cv2.COLOR_RGB2GRAY))
    flat = np.empty(image.shape, np.float32)
    for row in range(2):
        for column in range(2):
            flat[row::2, column::2] = _relative(np.ascontiguousarray(image[row::2, column::2]))
    return flat


def _relative(grey):
    grey = grey.astype(np.float32)
    grey += 1
    # The wide Gaussian is smooth: a picture of a quarter of the size gives the same.
    small = cv2.resize(grey, None, fx=0.25, fy=0.25, interpolation=cv2.INTER_AREA)
    wide = cv2.GaussianBlur(small, (0, 0), max(small.shape) / 16)
    grey /= cv2.resize(wide, grey.shape[::-1], interpolation=cv2.INTER_LINEAR)
    return grey


def find_blobs(image):
    """Dark round blobs of the uint8 ``image``, (h, w) raw or grey, or (h, w, 3) RGB.

    Flat field and Otsu's threshold find most dots, and so their size and distance. Then every
    pixel is divided by the page around it, a closing with dots of that size. A dot is the region
    darker than half of its own depth: this finds dots under smudges and glare too. The centre is
    the centroid of the ink, each pixel weighted by its darkness. A blob is rejected if it is much
    smaller than the others, or no filled ellipse. Blobs cut by the border are listed apart.
    """
    flat = flat_field(image)
    first = _dark_blobs(cv2.GaussianBlur(flat, (0, 0), 0.7))
    if len(first.xy) < 9:
        return first
    typical = np.median(first.area)
    distance = Nearest(first.xy).query(first.xy, 2)[0][:, 1]
    # Noise inside a large dot would break its edge up.
    smooth = cv2.GaussianBlur(flat, (0, 0), max(0.7, 0.1 * np.sqrt(typical)))
    del flat
    ink = _ink(smooth, 1.4 * np.sqrt(np.percentile(first.area, 90) * 4 / np.pi),
               0.8 * np.percentile(distance, 90))
    return _blobs(smooth, ink, max(_SMALL, 0.15 * typical))


def _dark_blobs(smooth):
    """:class:`Blobs` of what is darker than Otsu's threshold of the flat field."""
    grey = smooth * 128
    grey = np.clip(grey, 0, 255, out=grey).astype(np.uint8)
    level = cv2.threshold(grey, 0, 255, cv2.THRESH_BINARY + cv2.THRESH_OTSU)[0]
    return _blobs(smooth, smooth < (level + 0.5) / 128, _SMALL, rough=True)


def _ink(smooth, diameter, apart):
    """Mask of pixels darker than half of the depth of their dot; ``diameter`` and distance
    ``apart`` of dots in pixels."""
    depth = cv2.morphologyEx(smooth, cv2.MORPH_CLOSE, _square(diameter))
    np.divide(smooth, depth, out=depth)
    np.subtract(1, depth, out=depth)
    deepest = cv2.dilate(depth, _square(apart))
    ink = deepest > _FAINT * np.median(deepest)
    deepest /= 2
    ink &= depth > deepest
    return ink


def _square(side):
    return np.ones((2 * int(side / 2) + 1,) * 2, np.uint8)


def _blobs(smooth, dark, smallest, rough=False):
    """Blobs of the connected regions, of at least ``smallest`` pixels, of the mask ``dark``.

    ``rough``: their centres are those of the mask, not of the ink.
    """
    count, labels, stats, middles = cv2.connectedComponentsWithStats(dark.view(np.uint8),
                                                                     connectivity=4)
    height, width = smooth.shape
    left, top, wide, high, area = stats.T
    cut = (left <= 0) | (top <= 0) | (left + wide >= width) | (top + high >= height)
    small = area < smallest
    cut &= ~small
    good = ~(cut | small)
    good[0] = False
    if not good.any():
        return Blobs(np.empty((0, 2)), np.empty(0), _counts(small, good & False), middles[:0])
    xy, fill = _centres(None if rough else smooth, labels, good, middles, area)
    odd = good & ~((fill > _FILL[0]) & (fill < _FILL[1]))
    keep = good & ~odd
    cut[0] = False
    return Blobs(xy[keep], area[keep].astype(np.float64), _counts(small, odd), middles[cut])


def _counts(small, odd):
    reasons = {"too small": small, "not a filled ellipse": odd}
    # Component 0 is the page.
    return {reason: int(which[1:].sum()) for reason, which in reasons.items() if which[1:].any()}


def _centres(flat, labels, good, middles, area):
    """Centroid and fill of every component; rows of bad components are undefined.

    The centroid is that of the ink in the picture ``flat``, or of the component without one.
    """
    depth = None if flat is None else _depth(flat, int(np.sqrt(np.median(area[good]))) + 2)
    deepest, count = np.zeros(len(good), np.float32), len(good)
    for which, _, _, dark, _ in _pixels(labels, good, depth) if depth is not None else ():
        np.maximum.at(deepest, which, dark)
    (mass, x, y), (xx, yy, xy) = np.zeros((2, 3, count))
    for which, column, row, dark, own in _pixels(labels, good, depth):
        if depth is not None:
            ink = np.clip(dark - _DARK * deepest[which], 0, None).astype(np.float64)
            for total, weights in (mass, ink), (x, ink * column), (y, ink * row):
                total += np.bincount(which, weights, count)
        # The fill is that of the flat region itself, as a binary shape.
        mine = which[own]
        dx, dy = column[own] - middles[mine, 0], row[own] - middles[mine, 1]
        for total, product in (xx, dx * dx), (yy, dy * dy), (xy, dx * dy):
            total += np.bincount(mine, product, count)
    with np.errstate(all="ignore"):
        centre = middles if depth is None else np.stack([x, y], axis=1) / mass[:, None]
        ax, ay = (middles - centre).T
        xx, yy, xy = xx / area + ax * ax + 1 / 12, yy / area + ay * ay + 1 / 12, xy / area + ax * ay
        fill = area / (4 * np.pi * np.sqrt(np.maximum(xx * yy - xy * xy, 1e-12)))
    return centre, fill


def _depth(flat, size):
    """How much darker than the page around it each pixel is; ``size``: of a usual dot, pixels."""
    white = cv2.dilate(flat, np.ones((2 * size + 1,) * 2, np.uint8))
    white = cv2.erode(white, np.ones((size, size), np.uint8))
    white = cv2.blur(white, (2 * size + 1,) * 2)
    return np.subtract(white, flat, out=white)


def _pixels(labels, good, depth):
    """The pixels of the ``good`` components, one strip at a time, in the order of the rows.

    With a picture ``depth`` also the free pixels next to them.

    Yields
    ------
    which, column, row, depth : ndarray, shape (n,)
        Component, position, and value of the picture, or nothing.
    own : ndarray of bool, shape (n,)
        Whether the pixel is of the component, not next to it.
    """
    number = np.where(good, np.arange(len(good)), 0).astype(np.float32)
    around = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * _MARGIN + 1,) * 2)
    width = labels.shape[1]
    height = max(1, _STRIP // width)
    for top in range(0, len(labels), height):
        above = min(_MARGIN, top)
        part = labels[top - above:top + height + _MARGIN]
        near = number[part]
        if depth is not None:
            near = np.where(part > 0, near, cv2.dilate(near, around))
        near = near[above:above + height].ravel()
        at = np.flatnonzero(near)
        row = at // width
        yield (near[at].astype(np.intp), at - row * width, row + top,
               at[:0] if depth is None else depth[top:top + height].ravel()[at],
               part[above:above + height].ravel()[at] > 0)
