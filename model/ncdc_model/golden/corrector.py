"""Reference model of the whole frame in integers; the Verilog matches it bit for bit."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.golden.directional import crest_of
from ncdc_model.golden.network import coordinates
from ncdc_model.golden.picture import bilinear, corner_colours, fetches, raw_windows, window_address
from ncdc_model.golden.view import view_coordinates
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import scan_order
from ncdc_spec.interpolation import check_crest
from ncdc_spec.raw_gains import NO_RAW_GAINS, balanced_raw

__all__ = ["Corrected", "check_raw", "correct", "valid_coordinates", "window_bands"]

_ROWS = 32  # corrected rows at a time: bounds the memory that the windows take


@dataclass(frozen=True)
class Corrected:
    """A corrected frame: ``picture`` (height, width, 3) uint8 RGB; ``blank`` (height, width),
    true for a pixel without a source; ``fetches``, the number of windows that ``multiport`` reads.
    """
    picture: np.ndarray
    blank: np.ndarray
    fetches: int


def check_raw(raw, geometry):
    """Raise :class:`InputError` unless ``raw`` is an 8-bit raw frame of the distorted size."""
    if raw.ndim != 2 or raw.dtype != np.uint8:
        raise InputError(f"the raw frame has shape {raw.shape} and type {raw.dtype}, "
                         "one 8-bit channel is needed")
    if raw.shape != geometry.distorted[::-1]:
        raise InputError(f"the picture has {raw.shape[1]}x{raw.shape[0]} pixels, the descriptor is "
                         "for {}x{}".format(*geometry.distorted))


def correct(descriptor, raw, progress=lambda done, total: None, strip=0, crest=0,
            raw_gains=NO_RAW_GAINS, view=None):
    """Correct the ``raw`` Bayer frame (distorted height, width) uint8; returns :class:`Corrected`.

    ``progress(done, total)`` is called with the corrected rows done. ``strip``: as in
    :func:`ncdc_spec.geometry.scan_order`; only the number of fetches depends on it. ``crest``: its
    strength, 0 to 2, see :mod:`ncdc_model.golden.directional`. ``raw_gains``: gains of the raw
    frame's samples before interpolation, see :func:`ncdc_spec.raw_gains.balanced_raw`. ``view``:
    the :class:`~ncdc_spec.view.View` that the corrected frame shows.

    Raises
    ------
    InputError
        If the frame is not of the descriptor's distorted size, there is a crest and the
        interpolation is another one than directional, or there is a view and no nodes.
    """
    geometry, coordinate = descriptor.geometry, descriptor.formats.coordinate
    check_raw(raw, geometry)
    check_crest(crest, geometry.interpolation)
    width, height = view.size if view else geometry.corrected
    windows = raw_windows(balanced_raw(raw, geometry, raw_gains), geometry.interpolation)
    picture = np.empty((height, width, 3), np.uint8)
    valid = np.empty((height, width), bool)
    origins = np.empty((2, height, width), np.int64)
    for rows, x0, y0, fx, fy, not_blank in window_bands(descriptor, view):
        window = windows[y0, x0]
        added = crest_of(window, fx, fy, coordinate.f_bits, crest) if crest else 0
        picture[rows] = bilinear(corner_colours(window, x0, y0, geometry), fx, fy,
                                 coordinate.f_bits, geometry.interpolation, added)
        origins[:, rows], valid[rows] = (x0, y0), not_blank
        progress(rows.stop, height)
    picture[~valid] = geometry.fill
    return Corrected(picture, ~valid,
                     fetches(*(scan_order(a, strip) for a in (*origins, valid))))


def window_bands(descriptor, view=None):
    """Windows of a frame, a band of rows at a time: (slice of rows, x0, y0, fx, fy, valid).

    x0, y0, fx, fy are of :func:`ncdc_model.golden.picture.window_address`; ``valid`` is false where
    the pixel is blank. Each array has the shape (rows of the band, corrected width). ``view``: as
    for :func:`correct`.
    """
    geometry = descriptor.geometry
    width, height = view.size if view else geometry.corrected
    whole = None
    if view and view.rows:          # each row needs the one above
        v, u = np.indices((height, width))
        whole = valid_coordinates(descriptor, u, v, view)
    for top in range(0, height, _ROWS):
        rows = slice(top, min(top + _ROWS, height))
        v, u = np.mgrid[rows, 0:width]
        x, y, valid = ([part[rows] for part in whole] if whole else
                       valid_coordinates(descriptor, u, v, view))
        *window, inside = window_address(x, y, geometry, descriptor.formats.coordinate)
        yield rows, *window, valid & inside


def valid_coordinates(descriptor, u, v, view=None):
    """Raw coordinates (x', y') of pixels (u, v) of a ``view`` or of the trained picture, and
    whether each is in a valid span."""
    if view:
        return view_coordinates(descriptor, view, u, v)
    valid = descriptor.valid.mask(descriptor.geometry.corrected_width)[v, u]
    return *coordinates(descriptor, u, v), valid
