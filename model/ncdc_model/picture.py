"""The back end in integers: window, fast Bayer decoding, bilinear interpolation."""

import numpy as np

from ncdc_model.geometry import WINDOW

__all__ = ["bayer_quads", "bilinear", "fetches", "window_address"]


def window_address(x, y, geometry, coordinate):
    """Where the 3x3 raw window of raw coordinates (x', y') starts, and the place within it.

    Returns x0, y0 (pixels), fx, fy (raw fractions of ``coordinate.f_bits`` bits) and ``inside``.
    The four quads of the window have their centres half a pixel right of and below their first
    samples, hence x0 = floor(x' - 0.5). A window that leaves the image by one row or column is
    moved back in, to the picture's edge: whether a pixel has a source is decided by the valid
    rows, and the network's error there must not blank a pixel that has one. Further out,
    ``inside`` is false and x0 = y0 = fx = fy = 0.
    """
    origins, fractions, inside = [], [], True
    for value, size in ((x, geometry.distorted_width), (y, geometry.distorted_height)):
        shifted = np.asarray(value, np.int64) - (1 << (coordinate.f_bits - 1))
        origin, fraction = shifted >> coordinate.f_bits, shifted & ((1 << coordinate.f_bits) - 1)
        before, after = origin == -1, origin == size - WINDOW + 1
        inside = inside & (origin >= -1) & (origin <= size - WINDOW + 1)
        origins.append(origin + before - after)
        last = (1 << coordinate.f_bits) - 1
        fractions.append(np.where(before, 0, np.where(after, last, fraction)))
    return *(np.where(inside, value, 0) for value in (*origins, *fractions)), inside


def fetches(x0, y0, used):
    """Windows that the ``multiport`` fetcher reads: one whenever the quad changes.

    ``x0``, ``y0``, ``used``: of the pixels in scan order; a pixel not ``used`` reads nothing.
    """
    origins = np.stack([np.ravel(x0), np.ravel(y0)])[:, np.ravel(used)]
    if origins.shape[1] == 0:
        return 0
    return 1 + int((np.diff(origins, axis=1) != 0).any(axis=0).sum())


def bayer_quads(window, x0, y0, phase):
    """Four colours of each 3x3 raw ``window`` (..., 3, 3), shape (2, 2, 3, ...).

    Quad (j, i) is the 2x2 samples from row j, column i on: each holds one red, two green, one
    blue. Green is the sum of the two, 9 bit (units of a half); red and blue are doubled, so that
    all three are in units of a half. ``phase``: (column, row) parity of the red samples.
    """
    right, below = (np.asarray(x0) + phase[0]) & 1, (np.asarray(y0) + phase[1]) & 1
    quads = np.empty((2, 2, 3, *window.shape[:-2]), np.int64)
    for j in range(2):
        for i in range(2):
            q = window[..., j:j + 2, i:i + 2].astype(np.int64)
            # Whether this quad's first sample is in a red row and a red column.
            red_row, red_column = (below + j) % 2 == 0, (right + i) % 2 == 0
            a, b, c, d = q[..., 0, 0], q[..., 0, 1], q[..., 1, 0], q[..., 1, 1]
            quads[j, i, 0] = 2 * np.where(red_row, np.where(red_column, a, b),
                                          np.where(red_column, c, d))
            quads[j, i, 1] = np.where(red_row == red_column, b + c, a + d)
            quads[j, i, 2] = 2 * np.where(red_row, np.where(red_column, d, c),
                                          np.where(red_column, b, a))
    return quads


def bilinear(quads, fx, fy, f_bits):
    """8-bit colours (..., 3) at (fx, fy) between the four ``quads``, equations (30)-(32).

    ``quads``: (2, 2, 3, ...) in units of a half; ``fx``, ``fy``: fractions of ``f_bits`` bits.
    Exact but for one rounding (half up) at the end; a result is never above 255.
    """
    one = 1 << f_bits
    upper, lower = ((one - fx) * quads[j, 0] + fx * quads[j, 1] for j in range(2))
    total = (one - fy) * upper + fy * lower
    shift = 2 * f_bits + 1
    return np.moveaxis((total + (1 << (shift - 1))) >> shift, 0, -1).astype(np.uint8)
