"""Position of the corrected picture in the ideal plane, and its choice by a zoom."""

from dataclasses import dataclass

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE, Geometry

__all__ = ["Frame", "choose_frame", "parse_zoom"]

MAX_STRETCH = 8.0      # a frame that magnifies the middle less than 1/8 is blurred at its edge
_USEFUL = 75, 70, 65, 60, 50, 40, 30     # degrees from the axis that a flat picture may show
_OFF = {True: 1 / 20, False: 1 / 6}    # of the image's sides, by whether zoom is a number: largest
                                       # distance of a frame's centre, see choose_frame


@dataclass(frozen=True)
class Frame:
    """Corrected pixels: u = focal a + centre[0], v = aspect focal b + centre[1] of ideal (a, b).

    ``size`` is (width, height); ``focal`` is corrected pixels per unit of the ideal plane, and
    ``aspect`` the vertical focal length over the horizontal one.
    """
    size: tuple
    focal: float
    centre: tuple
    aspect: float = 1.0

    def ideal(self, u, v):
        """Ideal point of the corrected pixel (u, v)."""
        return ((np.asarray(u, np.float64) - self.centre[0]) / self.focal,
                (np.asarray(v, np.float64) - self.centre[1]) / (self.focal * self.aspect))

    def pixel(self, a, b):
        """Corrected pixel of the ideal point (a, b)."""
        return self.focal * a + self.centre[0], self.focal * self.aspect * b + self.centre[1]

    @property
    def matrix(self):
        """3x3 homography from the ideal plane to corrected pixels."""
        return np.array([[self.focal, 0, self.centre[0]],
                         [0, self.focal * self.aspect, self.centre[1]],
                         [0, 0, 1]])


def parse_zoom(zoom):
    """'fit', 'fill', or a positive float of the text or number ``zoom``."""
    if zoom in ("fit", "fill"):
        return zoom
    try:
        number = float(zoom)
    except (TypeError, ValueError):
        number = np.nan
    if not 0.01 <= number <= 100:
        raise InputError(f"zoom is {zoom!r}, fit, fill or a number of 0.01..100 is needed")
    return number


def choose_frame(to_ideal, to_distorted, distorted_size, size, zoom="fit"):
    """The corrected frame of ``size`` that shows the lens at ``zoom``.

    ``fit``: the middle row of the distorted image, from its left to its right edge, fills the
    corrected width; then some corrected pixels have no source. ``fill``: the smallest zoom at
    which every corrected pixel has a whole 3x3 raw window. A number: corrected pixels per
    distorted pixel at the middle. The frame is centred between the edges of the middle row and
    of the middle column. This point is far off the axis of a wide lens that is not exactly
    centred. The frame is centred on the lens's axis if the source of the point is more than a
    sixth of the image off its middle (at a number, a twentieth), or if an edge has no ideal point.
    Then ``fit`` puts the farther edge on the frame's border.

    Parameters
    ----------
    to_ideal, to_distorted : callable
        Between distorted pixels (x, y) and ideal points (a, b); not-a-number where undefined.
    distorted_size, size : (int, int)
        Width and height in pixels.
    zoom : str or float

    Raises
    ------
    InputError
        If the zoom is none of these, a size is out of range, or the lens's view is so wide that
        the edges of the image have no (or no usable) position in a flat picture.
    """
    zoom = parse_zoom(zoom)
    geometry = Geometry(*size, *distorted_size)
    (width, height), (dw, dh) = size, distorted_size
    mx, my = (dw - 1) / 2, (dh - 1) / 2
    a, b = to_ideal(np.array([0, dw - 1, mx, mx, mx]), np.array([my, my, 0, dh - 1, my]))
    off = _OFF[isinstance(zoom, float)]
    middle = (a[0] + a[1]) / 2, (b[2] + b[3]) / 2
    between = _distance(to_distorted, middle, distorted_size) <= off
    if not between:
        on_axis = _distance(to_distorted, (0.0, 0.0), distorted_size) <= _OFF[False]
        middle = (0.0, 0.0) if on_axis else (a[4], b[4])
    magnification = _magnification(to_distorted, *middle)

    def frame(focal):
        return Frame(tuple(size), float(focal), (float((width - 1) / 2 - focal * middle[0]),
                                                 float((height - 1) / 2 - focal * middle[1])))
    if isinstance(zoom, float):
        return frame(zoom * magnification)
    if not np.isfinite(a[:2]).all():
        raise InputError(f"zoom {zoom} needs a position in the flat picture for the left and right "
                         f"edges of the image, which this lens sees at 90 degrees or more; "
                         f"{_instead(frame, magnification, to_distorted, distorted_size)}")
    fit = frame((width - 1) / ((a[1] - a[0]) if between else
                               2 * max(middle[0] - a[0], a[1] - middle[0])))
    if zoom == "fit":
        shrink = magnification / fit.focal * (width / dw)
        if shrink > MAX_STRETCH:
            raise InputError(f"zoom fit would shrink the middle of the image {shrink:.1f} times, "
                             f"the limit is {MAX_STRETCH:g}; "
                             f"{_instead(frame, magnification, to_distorted, distorted_size)}")
        return fit
    return frame(_fill(frame, to_distorted, geometry, fit.focal))


def _instead(frame, magnification, to_distorted, distorted_size):
    """What to do about a lens that is too wide: text with a zoom at which the frame's left and
    right edges show what the image has, as far from the middle as is useful."""
    for degrees in _USEFUL:
        (width, height), reach = frame(1.0).size, np.tan(np.radians(degrees))
        zoom = float(f"{(width - 1) / 2 / reach / magnification:.1g}")
        u, v = np.array([0.0, width - 1]), np.full(2, (height - 1) / 2)
        x, y = to_distorted(*frame(zoom * magnification).ideal(u, v))
        limits = np.array(distorted_size) - 1
        if ((x >= 0) & (x <= limits[0]) & (y >= 0) & (y <= limits[1])).all():
            shown = _degrees(frame(zoom * magnification))
            return f"--zoom {zoom:g} shows {shown:.0f} degrees from left to right"
    return "give --zoom as a number"


def _degrees(frame):
    """Angle between the left and right edges of a :class:`Frame`."""
    (left, right), _ = frame.ideal(np.array([0.0, frame.size[0] - 1]), 0.0)
    return np.degrees(np.arctan(right) - np.arctan(left))


def _distance(to_distorted, point, size):
    """Distance of the source of the ideal ``point`` from the image's middle, in its sides."""
    x, y = to_distorted(*(np.array([value]) for value in point))
    parts = [abs(value[0] - (side - 1) / 2) / side for value, side in zip((x, y), size)]
    return max(parts) if np.isfinite(parts).all() else np.inf


def _magnification(to_distorted, a, b):
    """Distorted pixels per unit of the ideal plane at (a, b), the mean of both directions."""
    h = 1e-5
    x, y = to_distorted(a + h * np.array([1, -1, 0, 0]), b + h * np.array([0, 0, 1, -1]))
    return np.sqrt(abs((x[0] - x[1]) * (y[2] - y[3]) - (x[2] - x[3]) * (y[0] - y[1]))) / (2 * h)


def _fill(frame, to_distorted, geometry, focal):
    """Smallest focal length, from ``focal`` up, whose frame's border has whole windows."""
    width, height = geometry.corrected
    u = np.concatenate([np.arange(width)] * 2 + [np.zeros(height), np.full(height, width - 1)])
    v = np.concatenate([np.zeros(width), np.full(width, height - 1)] + [np.arange(height)] * 2)

    def whole(focal):
        x, y = to_distorted(*frame(focal).ideal(u, v))
        return bool(geometry.window_inside(x, y).all())
    lo = hi = focal
    while not whole(hi):
        lo, hi = hi, 1.25 * hi
        if hi > MAX_SIZE * focal:
            raise InputError("zoom fill found no frame in which every corrected pixel has a source")
    for _ in range(40):
        middle = (lo + hi) / 2
        lo, hi = (lo, middle) if whole(middle) else (middle, hi)
    return hi * (1 + 1e-9)
