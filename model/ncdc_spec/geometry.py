"""Image sizes, the colour filter phase, the scan normalisation, and which pixels have a source."""

from dataclasses import dataclass, field

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT, Interpolation

__all__ = ["BAYERS", "BAYER_PHASE", "Geometry", "MAX_SIZE", "MIN_SIZE", "MONO", "SCAN",
           "STRIP_UNIT", "ValidRows", "check_strip_width", "scan_order"]

MIN_SIZE = 8           # pixels per side: a row has time to fetch the next one's valid spans
MAX_SIZE = 4096        # pixels per side, for which positions, tags and sizes are wide enough
SPANS = 2              # spans of pixels with a source that one row can have
SCAN = Q(1, 31)        # origin and step of the normalised scan
STRIP_UNIT = 32        # columns: the width of a strip is a multiple of it

# Phase of the colour filter array: (column, row) parity of its red samples.
BAYER_PHASE = {"RGGB": (0, 0), "GRBG": (1, 0), "GBRG": (0, 1), "BGGR": (1, 1)}
MONO = "MONO"           # instead of a pattern: a grey sensor, which has no colour filter
BAYERS = (*BAYER_PHASE, MONO)


def check_strip_width(strip_width):
    """Raise :class:`InputError` unless ``strip_width`` is one that the hardware can scan."""
    if not 0 <= strip_width <= MAX_SIZE or strip_width % STRIP_UNIT:
        raise InputError(f"the strip width is {strip_width}, 0 (raster) or a multiple of "
                         f"{STRIP_UNIT} up to {MAX_SIZE} is needed")


def scan_order(values, strip_width=0):
    """``values`` of an image, shape (height, width, ...), as (pixels, ...) in the hardware's order.

    Strips of ``strip_width`` columns from left to right, the last one what is left; in each the
    rows from the top down, in each of those the columns from left to right. 0: one strip, a raster,
    which may share the memory of ``values``.

    Raises
    ------
    InputError
        If there is no strip of that width.
    """
    check_strip_width(strip_width)
    width = values.shape[1]
    if not strip_width:
        return values.reshape(-1, *values.shape[2:])
    edges = range(0, width, strip_width)
    return np.concatenate([values[:, left:left + strip_width].reshape(-1, *values.shape[2:])
                           for left in edges])


@dataclass(frozen=True)
class Geometry:
    """Sizes in pixels of the corrected and the distorted image, filter phase and fill colour,
    and the interpolation.

    Pixel centres are at integer coordinates; the corrected image spans (0, 0) to
    (corrected_width - 1, corrected_height - 1).

    Raises
    ------
    InputError
        If a side is outside 8..4096, the Bayer pattern is unknown, a grey sensor's frame is to be
        interpolated as fast, or the fill is no 8-bit RGB.
    """
    corrected_width: int
    corrected_height: int
    distorted_width: int
    distorted_height: int
    bayer: str = "RGGB"
    fill: tuple = (0, 0, 0)
    # Not in the text of a geometry, of which the digest of a descriptor is made: an older one's
    # digest stays what it was.
    interpolation: Interpolation = field(default=FAST, repr=False)

    max_size = MAX_SIZE     # of a side; not a field

    def __post_init__(self):
        for name in ("corrected_width", "corrected_height", "distorted_width", "distorted_height"):
            value = getattr(self, name)
            if type(value) is not int or not MIN_SIZE <= value <= self.max_size:
                raise InputError(f"{name} is {value}, the limits are {MIN_SIZE} and "
                                 f"{self.max_size}")
        if self.bayer not in BAYERS:
            raise InputError(f"bayer is {self.bayer!r}, one of {', '.join(BAYERS)} is needed")
        if self.mono and self.interpolation == FAST:
            raise InputError(f"bayer is {MONO}, a grey sensor needs the interpolation "
                             f"{GRADIENT.name} or {DIRECTIONAL.name}, not {FAST.name}")
        if len(self.fill) != 3 or not all(type(c) is int and 0 <= c <= 255 for c in self.fill):
            raise InputError(f"fill is {list(self.fill)}, three values of 0..255 are needed")

    @property
    def corrected(self):
        """(width, height) of the corrected image."""
        return self.corrected_width, self.corrected_height

    @property
    def distorted(self):
        """(width, height) of the distorted image."""
        return self.distorted_width, self.distorted_height

    @property
    def mono(self):
        """Whether the sensor is grey: it has no colour filter."""
        return self.bayer == MONO

    @property
    def phase(self):
        """(column, row) parity of the red samples; (0, 0) for a grey sensor, without a meaning."""
        return BAYER_PHASE.get(self.bayer, (0, 0))

    def scan(self):
        """(origin_x, step_x, origin_y, step_y), raw in :data:`SCAN`.

        The normalised coordinate of pixel u is origin + u * step, between -0.9999 and 0.9999 and
        symmetric about the centre of the image. The step is even, so that the origin, half of
        the span, is exact: no rounding enters before the one to the neuron's input format.
        """
        values = []
        for size in self.corrected:
            step = 2 * int(0.9999 * 2**SCAN.f_bits / (size - 1))
            values += [-step * (size - 1) // 2, step]
        return tuple(values)

    def normalise(self, u, v):
        """Real normalised coordinates of corrected pixels, exactly those of the hardware's scan."""
        origin_x, step_x, origin_y, step_y = (value / 2.0**SCAN.f_bits for value in self.scan())
        return origin_x + np.asarray(u) * step_x, origin_y + np.asarray(v) * step_y

    def inside_by(self, x, y):
        """Distance in pixels of distorted (x, y) from the line on which their corners meet the
        image's edge: positive inside."""
        core, offset = self.interpolation.core, self.interpolation.offset
        return np.minimum.reduce([side for value, size in zip((x, y), self.distorted) for side in
                                  (value - offset, size - core + 1 + offset - value)])

    def window_inside(self, x, y):
        """Whether all corners around distorted coordinates (x, y) lie in the image.

        The first corner has the index floor(x - offset), see :class:`Interpolation`. The corners of
        the fast one are four quads of 2x2 samples, whose centres are half a pixel right of and
        below the samples.
        """
        core, offset = self.interpolation.core, self.interpolation.offset
        x0, y0 = np.floor(np.asarray(x) - offset), np.floor(np.asarray(y) - offset)
        return ((x0 >= 0) & (x0 <= self.distorted_width - core)
                & (y0 >= 0) & (y0 <= self.distorted_height - core))


@dataclass(frozen=True)
class ValidRows:
    """Which corrected pixels have a source: up to two spans in each row.

    A barrel lens leaves the top and bottom middle of a filled frame without a source while the
    corners have one, so that a row may have two spans.

    Parameters
    ----------
    spans : ndarray of int, shape (height, 4)
        start0, stop0, start1, stop1 of each row: pixel u is valid if start <= u < stop of
        either span; an empty span has start = stop = 0.
    """
    spans: np.ndarray

    @classmethod
    def of_mask(cls, mask):
        """Spans of a boolean (height, width) ``mask``; of more than two, the two longest stay."""
        spans = np.zeros((mask.shape[0], 2 * SPANS), np.int64)
        edges = np.diff(np.pad(mask.view(np.int8), ((0, 0), (1, 1))), axis=1)
        (rows, starts), (_, stops) = np.nonzero(edges == 1), np.nonzero(edges == -1)
        count = np.bincount(rows, minlength=len(spans))
        number = np.arange(len(rows)) - np.repeat(np.cumsum(count) - count, count)
        few = (count <= SPANS)[rows]
        spans[rows[few], 2 * number[few]] = starts[few]
        spans[rows[few], 2 * number[few] + 1] = stops[few]
        for row in np.flatnonzero(count > SPANS):
            begin, end = starts[rows == row], stops[rows == row]
            longest = np.sort(np.argsort(begin - end, kind="stable")[:SPANS])
            spans[row] = np.stack([begin, end], axis=1)[longest].ravel()
        return cls(spans)

    @classmethod
    def everything(cls, width, height):
        """Every pixel valid."""
        return cls(np.tile([0, width, 0, 0], (height, 1)))

    def mask(self, width):
        """Boolean (height, width) array, true where a pixel has a source."""
        u = np.arange(width)
        start0, stop0, start1, stop1 = self.spans.T[:, :, None]
        return (u >= start0) & (u < stop0) | (u >= start1) & (u < stop1)

    def check(self, width, height):
        """Raise :class:`InputError` unless the spans fit an image of ``width`` x ``height``."""
        if self.spans.shape != (height, 2 * SPANS):
            raise InputError(f"the valid spans cover {len(self.spans)} rows, the image has "
                             f"{height}")
        bad = ((self.spans < 0) | (self.spans > width)).any(axis=1)
        bad |= (self.spans[:, 0::2] > self.spans[:, 1::2]).any(axis=1)
        if bad.any():
            row = int(np.flatnonzero(bad)[0])
            raise InputError(f"valid span {self.spans[row].tolist()} of row {row} leaves the "
                             f"limits 0 and {width} or ends before it starts")
