"""The back end in integers: window, Bayer decoding, bilinear interpolation."""

import numpy as np

from ncdc_model.golden.directional import directional_colours
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT

__all__ = ["bayer_quads", "bilinear", "corner_colours", "fetches", "gradient_colours",
           "grey_corners", "raw_windows", "window_address"]

# Weights in sixteenths of the samples around one, for the colours that it does not measure, by
# Malvar, He and Cutler ("High-quality linear interpolation for demosaicing of Bayer-patterned
# color images", 2004). Its own colour is the sample itself.
_GREEN_AT_CHROMA = np.array([[0, 0, -2, 0, 0],          # green, at a red or blue sample
                             [0, 0, 4, 0, 0],
                             [-2, 4, 8, 4, -2],
                             [0, 0, 4, 0, 0],
                             [0, 0, -2, 0, 0]])
_ACROSS_AT_GREEN = np.array([[0, 0, 1, 0, 0],           # colour of the samples left and right
                             [0, -2, 0, -2, 0],
                             [-2, 8, 10, 8, -2],
                             [0, -2, 0, -2, 0],
                             [0, 0, 1, 0, 0]])
_DOWN_AT_GREEN = _ACROSS_AT_GREEN.T                     # colour of the samples above and below
_CHROMA_AT_CHROMA = np.array([[0, 0, -3, 0, 0],         # blue at a red sample, red at a blue one
                              [0, 4, 0, 4, 0],
                              [-3, 0, 12, 0, -3],
                              [0, 4, 0, 4, 0],
                              [0, 0, -3, 0, 0]])
_OWN = np.zeros((5, 5), np.int64)
_OWN[2, 2] = 16


def window_address(x, y, geometry, coordinate):
    """First corner of the interpolation at raw coordinates (x', y'), and the fractions after it.

    Returns x0, y0 (pixels), fx, fy (raw fractions of ``coordinate.f_bits`` bits) and ``inside``.
    x0 = floor(x' - offset) with the offset of the interpolation: the fast one's quads have their
    centres half a pixel right of and below their first samples. Sources outside the image by one
    row or column are clamped to its edge: the valid rows decide whether a pixel has a source, and
    the network's error there must not blank a pixel that has one. Farther outside, ``inside`` is
    false and x0 = y0 = fx = fy = 0.
    """
    core = geometry.interpolation.core
    offset = int(geometry.interpolation.offset * (1 << coordinate.f_bits))
    origins, fractions, inside = [], [], True
    for value, size in ((x, geometry.distorted_width), (y, geometry.distorted_height)):
        shifted = np.asarray(value, np.int64) - offset
        origin, fraction = shifted >> coordinate.f_bits, shifted & ((1 << coordinate.f_bits) - 1)
        before, after = origin == -1, origin == size - core + 1
        inside = inside & (origin >= -1) & (origin <= size - core + 1)
        origins.append(origin + before - after)
        last = (1 << coordinate.f_bits) - 1
        fractions.append(np.where(before, 0, np.where(after, last, fraction)))
    return *(np.where(inside, value, 0) for value in (*origins, *fractions)), inside


def fetches(x0, y0, used):
    """Number of windows that the ``multiport`` fetcher reads: one whenever the quad changes.

    ``x0``, ``y0``, ``used``: arrays in scan order; a pixel not ``used`` reads nothing.
    """
    origins = np.stack([np.ravel(x0), np.ravel(y0)])[:, np.ravel(used)]
    if origins.shape[1] == 0:
        return 0
    return 1 + int((np.diff(origins, axis=1) != 0).any(axis=0).sum())


def bayer_quads(window, x0, y0, phase):
    """Four colours of each 3x3 raw ``window`` (..., 3, 3), shape (2, 2, 3, ...).

    Quad (j, i) has the 2x2 samples from row j, column i on: one red, two green, one blue. Green is
    the sum of the two, 9 bits in units of a half. Red and blue are doubled, so that all three are
    in units of a half. ``phase``: (column, row) parity of the red samples.
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


def gradient_colours(window, x0, y0, phase):
    """Four colours of each 6x6 raw ``window`` (..., 6, 6), shape (2, 2, 3, ...).

    Corner (j, i) is the sample in row 2 + j, column 2 + i of the window. All colours are exact, in
    units of a sixteenth; they are not clamped. ``phase``: (column, row) parity of the red samples;
    ``x0``, ``y0``: column and row of the first corner in the frame.
    """
    right, below = (np.asarray(x0) + phase[0]) & 1, (np.asarray(y0) + phase[1]) & 1
    colours = np.empty((2, 2, 3, *window.shape[:-2]), np.int64)
    for j in range(2):
        for i in range(2):
            around = window[..., j:j + 5, i:i + 5].astype(np.int64)
            own, green, across, down, chroma = (
                (around * kernel).sum(axis=(-2, -1)) for kernel in
                (_OWN, _GREEN_AT_CHROMA, _ACROSS_AT_GREEN, _DOWN_AT_GREEN, _CHROMA_AT_CHROMA))
            red_row, red_column = (below + j) % 2 == 0, (right + i) % 2 == 0
            colours[j, i, 0] = np.where(red_row, np.where(red_column, own, across),
                                       np.where(red_column, down, chroma))
            colours[j, i, 1] = np.where(red_row == red_column, green, own)
            colours[j, i, 2] = np.where(red_row, np.where(red_column, chroma, down),
                                       np.where(red_column, across, own))
    return colours


def grey_corners(window):
    """The four samples in the middle of each 6x6 grey ``window``, shape (2, 2, 3, ...).

    Each in all three colours, in units of a sixteenth, as of :func:`gradient_colours`.
    """
    middle = np.moveaxis(window[..., 2:4, 2:4].astype(np.int64), (-2, -1), (0, 1))
    return np.repeat(16 * middle[:, :, None], 3, axis=2)


_DECODERS = {FAST: bayer_quads, GRADIENT: gradient_colours, DIRECTIONAL: directional_colours}


def raw_windows(raw, interpolation):
    """The windows of a raw frame (height, width), indexed by their first corner.

    Element [y0, x0] is the window, (window, window). Samples outside the frame are mirrored about
    its first and last row and column, which keeps the pattern of the colour filter.
    """
    framed = np.pad(raw, interpolation.margin, mode="reflect") if interpolation.margin else raw
    return np.lib.stride_tricks.sliding_window_view(framed, (interpolation.window,) * 2)


def corner_colours(window, x0, y0, geometry):
    """Colours of the four corners of each raw ``window``, by the sensor and the interpolation of
    ``geometry``: see ``bayer_quads``, ``gradient_colours``, ``directional_colours`` and
    ``grey_corners``."""
    if geometry.mono:
        return grey_corners(window)
    return _DECODERS[geometry.interpolation](window, x0, y0, geometry.phase)


def bilinear(quads, fx, fy, f_bits, interpolation=FAST, crest=0):
    """8-bit colours (..., 3) at (fx, fy) between the four ``quads``, equations (30)-(32).

    ``quads``: (2, 2, 3, ...) in the units of ``interpolation``; ``fx``, ``fy``: fractions of
    ``f_bits`` bits. The colours between the quads of a row keep the fraction bits that the
    interpolation states; lower ones are cut off. The result is rounded half up, then clamped to
    0..255. ``crest``: added to all colours before the rounding, in units of ``2**-row_bits``, see
    :mod:`ncdc_model.golden.directional`.
    """
    one, cut = 1 << f_bits, interpolation.cut(f_bits)
    upper, lower = ((one - fx) * quads[j, 0] + fx * quads[j, 1] >> cut for j in range(2))
    total = (one - fy) * upper + fy * lower + (np.asarray(crest) << f_bits)
    shift = 2 * f_bits + interpolation.unit_bits - cut
    rounded = total + (1 << shift - 1) >> shift
    return np.moveaxis(np.clip(rounded, 0, 255), 0, -1).astype(np.uint8)
