"""A test card that a lens bends and its correction makes straight again."""

import numpy as np

from ncdc_model.golden.inverse import inverse_map
from ncdc_model.images import mosaic

__all__ = ["CODES", "card_at", "card_codes"]

CODES = 4               # levels of a sample: what two bits can name
_PERIODS = 12           # of the grid along the longer side
_LINE = .08             # width of a line, of the grid's period
_RADII = 1, 4           # of the circles, in periods
_BARS = np.array([[1, 1, 0], [0, 1, 1], [0, 1, 0], [1, 0, 1], [1, 0, 0], [0, 0, 1]])
"""Colours of the bars from left to right, the brightest one first."""


def card_at(u, v, size):
    """Light (..., 3) in 0..1 of the card at the pixels (u, v) of a picture of ``size``.

    White lines and circles are on dark colour bars. In a wide picture a bar is as wide as two
    meshes of the grid. A line's edge is as wide as a pixel.
    """
    width, height = size
    period = max(size) / _PERIODS
    x, y = (np.asarray(at) - (side - 1) / 2 for at, side in ((u, width), (v, height)))
    # From each point to the middle of the next line, in pixels.
    lines = [abs((at + period / 2) % period - period / 2) for at in (x, y)]
    lines += [abs(np.hypot(x, y) - radius * period) for radius in _RADII]
    shown = np.clip(_LINE * period / 2 + .5 - np.minimum.reduce(lines), 0, 1)[..., None]
    bar = np.clip((np.asarray(u) + .5) * len(_BARS) // width, 0, len(_BARS) - 1).astype(int)
    return shown + (1 - shown) * _BARS[bar] / (CODES - 1)


def card_codes(descriptor):
    """The card as a camera with the lens of ``descriptor`` sees it: uint8 (height, width) codes.

    A code of 0 to 3 is a sample of the raw frame, from black to white.
    """
    g = descriptor.geometry
    light = card_at(*inverse_map(descriptor), g.corrected)
    codes = np.rint((CODES - 1) * light).astype(np.uint8)
    return mosaic(codes, g.bayer)
