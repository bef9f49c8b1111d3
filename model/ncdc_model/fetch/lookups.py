"""The look-ups that the cache makes for a frame: a box of samples each, in the order of the scan."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.corrector import window_bands
from ncdc_model.geometry import WINDOW, scan_order

__all__ = ["Lookups", "Windows", "frame_windows", "lookups"]


@dataclass(frozen=True)
class Windows:
    """Where the 3x3 windows of a corrected frame start: arrays of shape (height, width).

    Parameters
    ----------
    x0, y0 : ndarray of int32
        First column and row; zero where the pixel is blank.
    used : ndarray of bool
        False where the pixel is blank and reads nothing.
    """
    x0: np.ndarray
    y0: np.ndarray
    used: np.ndarray

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
    pixels : int
        Corrected pixels of the frame.
    """
    x0: np.ndarray
    y0: np.ndarray
    x1: np.ndarray
    y1: np.ndarray
    used: np.ndarray
    pixels: int

    def __len__(self):
        return len(self.x0)


def frame_windows(descriptor, progress=lambda done, total: None):
    """:class:`Windows` of a trained map; ``progress(done, total)`` counts corrected rows."""
    width, height = descriptor.geometry.corrected
    x0, y0 = np.empty((2, height, width), np.int32)
    used = np.empty((height, width), bool)
    for rows, columns, lines, _, _, known in window_bands(descriptor):
        x0[rows], y0[rows], used[rows] = columns, lines, known
        progress(rows.stop, height)
    return Windows(x0, y0, used)


def lookups(windows, strip=0):
    """:class:`Lookups` of a frame: one for each pixel, in raster order or in strips."""
    x0, y0, used = windows.scanned(strip)
    far = WINDOW - 1
    return Lookups(x0, y0, x0 + far, y0 + far, used, x0.size)
