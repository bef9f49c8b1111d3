"""The look-ups that the cache makes for a frame: boxes of samples in the order of the scan."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.corrector import window_bands
from ncdc_model.geometry import scan_order
from ncdc_model.hardware import check_lanes
from ncdc_model.interpolation import FAST, Interpolation

__all__ = ["Lookups", "Windows", "frame_windows", "lookups"]


@dataclass(frozen=True)
class Windows:
    """Where the windows of a corrected frame are: arrays of shape (height, width).

    Parameters
    ----------
    x0, y0 : ndarray of int32
        Column and row that name the first place; zero where the pixel is blank.
    used : ndarray of bool
        False where the pixel is blank and reads nothing.
    interpolation : Interpolation
    distorted : (int, int), optional
        Width and height of the raw frame; needed of an interpolation whose windows may leave it.
    """
    x0: np.ndarray
    y0: np.ndarray
    used: np.ndarray
    interpolation: Interpolation = FAST
    distorted: tuple = (None, None)

    def scanned(self, strip=0):
        """x0, y0, used, each of shape (pixels,), in the order of the scan.

        ``strip``: columns of a strip, 0 for raster, see :func:`ncdc_model.geometry.scan_order`.
        """
        return tuple(scan_order(array, strip) for array in (self.x0, self.y0, self.used))


@dataclass(frozen=True)
class Lookups:
    """Boxes of samples in the order in which the cache looks them up, arrays of shape (N,).

    Parameters
    ----------
    x0, y0, x1, y1 : ndarray of int32
        First and last column and row.
    used : ndarray of bool
        False for a look-up that reads nothing.
    pixel : ndarray of int64
        First pixel, in the order of the scan.
    pixels : int
        Corrected pixels of the frame.
    interpolation : Interpolation
    width, strip, lanes : int
        Columns of the corrected picture and of the scan's strips, 0 for raster; pixels of a group.
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


def frame_windows(descriptor, progress=lambda done, total: None):
    """:class:`Windows` of a trained map; ``progress(done, total)`` counts corrected rows."""
    width, height = descriptor.geometry.corrected
    x0, y0 = np.empty((2, height, width), np.int32)
    used = np.empty((height, width), bool)
    for rows, columns, lines, _, _, valid in window_bands(descriptor):
        x0[rows], y0[rows], used[rows] = columns, lines, valid
        progress(rows.stop, height)
    geometry = descriptor.geometry
    return Windows(x0, y0, used, geometry.interpolation, geometry.distorted)


def lookups(windows, strip=0, lanes=1):
    """:class:`Lookups` of a frame in raster order, or in strips of ``strip`` columns.

    One for each group of ``lanes`` neighbours of a row, if all samples of its pixels, those that
    are not blank, fit a box that the tile memory gives in one clock: four rows, or eight of an
    interpolation with larger windows, and two words of ``Interpolation.box_word`` samples across.
    Else the group is cut in halves, these likewise.

    Raises
    ------
    InputError
        If ``lanes`` does not divide the width.
    """
    x0, y0, used = windows.scanned(strip)
    width = windows.x0.shape[1]
    scan = windows.interpolation, width, strip, lanes
    needs = windows.interpolation
    (x0, x1), (y0, y1) = (needs.bounds(first, size)
                          for first, size in zip((x0, y0), windows.distorted))
    if lanes == 1:
        return Lookups(x0, y0, x1, y1, used, np.arange(x0.size), x0.size, *scan)
    check_lanes(width, lanes)
    # A group is cut where it has no box of its own: `begins` marks the first lane of each box.
    edges = _Edges(x0, y0, x1, y1, used, needs, needs.box_word(lanes))
    boxes, begins = edges, np.ones(x0.shape, bool)
    while lanes > 1:
        joined = edges.joined()
        span = x0.size // joined.used.size
        whole = np.repeat(joined.fits, span)
        boxes = boxes.where(whole, joined, span)
        begins &= ~whole | (np.arange(x0.size) % span == 0)
        edges, lanes = joined, lanes // 2
    return Lookups(*(array[begins] for array in boxes.arrays()), np.flatnonzero(begins), x0.size,
                   *scan)


@dataclass(frozen=True)
class _Edges:
    """Boxes around runs of pixels of equal length.

    ``word``: samples of a word of the tile memory.
    """
    x0: np.ndarray
    y0: np.ndarray
    x1: np.ndarray
    y1: np.ndarray
    used: np.ndarray
    interpolation: Interpolation
    word: int

    def arrays(self):
        return self.x0, self.y0, self.x1, self.y1, self.used

    @property
    def fits(self):
        """Whether one clock is enough."""
        needs = self.interpolation
        across = self.x1 // self.word - self.x0 // self.word
        down = self.y1 // needs.tile_height - self.y0 // needs.tile_height
        return ~self.used | ((across <= 1) & (self.y1 - self.y0 < needs.box_rows)
                             & (down < needs.tile_rows))

    def joined(self):
        """Boxes around each two neighbours, of which a blank one takes no part."""
        a, b = (_Edges(*(array[k::2] for array in self.arrays()), self.interpolation, self.word)
                for k in (0, 1))
        both = a.used & b.used
        return _Edges(*(np.where(both, least(one, other), np.where(b.used, other, one))
                        for one, other, least in zip(a.arrays()[:4], b.arrays()[:4],
                                                     (np.minimum,) * 2 + (np.maximum,) * 2)),
                      a.used | b.used, self.interpolation, self.word)

    def where(self, chosen, other, span):
        """These, or where ``chosen`` those of ``other``, each repeated ``span`` times."""
        return _Edges(*(np.where(chosen, np.repeat(new, span), old)
                        for old, new in zip(self.arrays(), other.arrays())),
                      self.interpolation, self.word)
