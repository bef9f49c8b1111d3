"""Look-ups of the cache for a frame: boxes of samples in the order of the scan."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.correction import Correction
from ncdc_spec.geometry import scan_order
from ncdc_spec.hardware import check_lanes
from ncdc_spec.interpolation import FAST, Interpolation

__all__ = ["Lookups", "Windows", "frame_windows", "lookups", "pieces"]

_POSITION = np.int16       # column or row of a sample: those of a raw frame have 12 bits
_PIECE = 1 << 18        # look-ups at a time: bounds the memory of their temporary arrays


def pieces(count):
    """Slices of whole groups of pixels that cover ``count`` look-ups or pixels in turn."""
    return [slice(first, min(first + _PIECE, count)) for first in range(0, count, _PIECE)]


@dataclass(frozen=True)
class Windows:
    """Positions of the windows of a corrected frame: arrays of shape (height, width).

    Parameters
    ----------
    x0, y0 : ndarray of int16
        Column and row of the first corner; zero if the pixel is blank.
    used : ndarray of bool
        False if the pixel is blank and reads nothing.
    interpolation : Interpolation
    distorted : (int, int), optional
        Width and height of the raw frame, for an interpolation whose windows may leave it.
    """
    x0: np.ndarray
    y0: np.ndarray
    used: np.ndarray
    interpolation: Interpolation = FAST
    distorted: tuple = (None, None)

    def scanned(self, strip=0):
        """x0, y0, used, each of shape (pixels,), in the order of the scan.

        ``strip``: columns of a strip, 0 for raster, see :func:`ncdc_spec.geometry.scan_order`.
        """
        return tuple(scan_order(array, strip) for array in (self.x0, self.y0, self.used))


@dataclass(frozen=True)
class Lookups:
    """Boxes of samples in the order of the cache's look-ups, arrays of shape (N,).

    Parameters
    ----------
    x0, y0, x1, y1 : ndarray of int16
        First and last column and row.
    used : ndarray of bool
        False for a look-up that reads nothing.
    pixel : ndarray of int32
        First pixel, in the order of the scan.
    pixels : int
        Corrected pixels of the frame.
    interpolation : Interpolation
    width, strip, lanes : int
        Columns of the corrected picture and of the scan's strips (0: raster); pixels of a group.
    """
    x0: np.ndarray
    y0: np.ndarray
    x1: np.ndarray
    y1: np.ndarray
    used: np.ndarray
    pixel: np.ndarray
    pixels: int
    interpolation: Interpolation
    width: int
    strip: int
    lanes: int

    def __len__(self):
        return len(self.x0)

    @property
    def rows(self):
        """(Columns of each strip, an ndarray; rows of a strip)."""
        lefts = np.arange(0, self.width, self.strip or self.width)
        return np.diff(np.append(lefts, self.width)), self.pixels // self.width


def frame_windows(descriptor, progress=lambda done, total: None, view=None):
    """:class:`Windows` of a trained map, or of a :class:`~ncdc_spec.view.View` of it;
    ``progress(done, total)`` counts corrected rows."""
    # Not the cached correction: its arrays would stay, 12 bytes a pixel.
    x0, y0, used = Correction(descriptor, view=view).corners(progress)
    geometry = descriptor.geometry
    return Windows(x0, y0, used, geometry.interpolation, geometry.distorted)


def lookups(windows, strip=0, lanes=1):
    """:class:`Lookups` of a frame in raster order, or in strips of ``strip`` columns.

    A group of ``lanes`` neighbours of a row is one look-up if all samples of its pixels that are
    not blank fit a box that the tile memory reads in one clock: four rows, or eight for an
    interpolation with larger windows, and the words of ``Interpolation.box_words``. Else the group
    is divided in halves, and these likewise.

    Raises
    ------
    InputError
        If ``lanes`` does not divide the width.
    """
    x0, y0, used = windows.scanned(strip)
    width, needs = windows.x0.shape[1], windows.interpolation
    scan = x0.size, needs, width, strip, lanes
    if lanes == 1:
        pixel = np.arange(x0.size, dtype=np.int32)
        return Lookups(*_bounds(windows, x0, y0), used, pixel, *scan)
    check_lanes(width, lanes)
    parts = []
    for piece in pieces(x0.size):
        edges = _Edges(*_bounds(windows, x0[piece], y0[piece]), used[piece], needs,
                       needs.box_words(lanes))
        boxes, begins = _grouped(edges, lanes)
        parts.append((*(array[begins] for array in boxes.arrays()),
                      (piece.start + np.flatnonzero(begins)).astype(np.int32)))
    return Lookups(*(np.concatenate(part) for part in zip(*parts)), *scan)


def _bounds(windows, x0, y0):
    """First columns, first rows, last columns and last rows of the samples of ``windows`` whose
    first corners are (x0, y0)."""
    needs, (width, height) = windows.interpolation, windows.distorted
    (x0, x1), (y0, y1) = needs.bounds(x0, width), needs.bounds(y0, height)
    return x0, y0, x1, y1


def _grouped(edges, lanes):
    """The boxes of groups of ``lanes`` pixels, for each pixel, and which pixels begin one.

    A group that does not fit a box is divided.
    """
    boxes, begins = edges, np.ones(edges.used.shape, bool)
    size = begins.size
    while lanes > 1:
        joined = edges.joined()
        span = size // joined.used.size
        whole = np.repeat(joined.fits, span)
        boxes = boxes.where(whole, joined, span)
        begins &= ~whole | (np.arange(size) % span == 0)
        edges, lanes = joined, lanes // 2
    return boxes, begins


@dataclass(frozen=True)
class _Edges:
    """Boxes around runs of equally many pixels.

    ``words``: (number, samples) of the words of a box in a row.
    """
    x0: np.ndarray
    y0: np.ndarray
    x1: np.ndarray
    y1: np.ndarray
    used: np.ndarray
    interpolation: Interpolation
    words: tuple

    def arrays(self):
        return self.x0, self.y0, self.x1, self.y1, self.used

    @property
    def fits(self):
        """Whether one clock is enough."""
        needs = self.interpolation
        most, samples = self.words
        across = self.x1 // samples - self.x0 // samples
        down = self.y1 // needs.tile_height - self.y0 // needs.tile_height
        return ~self.used | ((across < most) & (self.y1 - self.y0 < needs.box_rows)
                             & (down < needs.tile_rows))

    def joined(self):
        """Boxes around each two neighbours; blank ones are ignored."""
        a, b = (_Edges(*(array[k::2] for array in self.arrays()), self.interpolation, self.words)
                for k in (0, 1))
        both = a.used & b.used
        return _Edges(*(np.where(both, outer(one, other), np.where(b.used, other, one))
                        for one, other, outer in zip(a.arrays()[:4], b.arrays()[:4],
                                                     (np.minimum,) * 2 + (np.maximum,) * 2)),
                      a.used | b.used, self.interpolation, self.words)

    def where(self, chosen, other, span):
        """These, or where ``chosen`` those of ``other``, each repeated ``span`` times."""
        return _Edges(*(np.where(chosen, np.repeat(new, span), old)
                        for old, new in zip(self.arrays(), other.arrays())),
                      self.interpolation, self.words)
