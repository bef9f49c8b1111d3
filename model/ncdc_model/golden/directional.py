"""Directional colour interpolation in integers: one decision per pixel, kernels of small weights.

The pixel lies between the four samples in rows and columns 2 and 3 of its 6x6 window. With the
second differences d = w0 - w1 - w2 + w3 of four samples in line, of six bits each::

    m(d) = d if d >= 0 else -d - 1
    h = sum of m(d) along rows: all three of rows 2 and 3, the middle one of rows 1 and 4
    v = the same along columns
    s = 1     if 2h + 8 <= v            -1     if 2v + 8 <= h
        1/2   if 4h + 8 <= 3v           -1/2   if 4v + 8 <= 3h            else 0

so that s is positive where colour differences vary less along the row. Around a sample c, with
the sums H of its neighbours left and right, V above and below, Q and P of those two away along row
and column, D of the four diagonal ones, Kv of the four two rows and a column away, Kh of those a
row and two columns away, and with a product s x that is floor(x / 2) for s = 1/2, in sixteenths::

    at red or blue   t = 4c - P - Q,   e = 3 (H - V) - (Q - P)
                     green       4 (H + V) + t + floor(t / 2) + s e
                     the other   4D + 2t + 2 s e
    at green         a = 4H + 2c - Q,   b = 8c + 2H + Kv - 2D
                     the row's   a + b + s (a - b)
                     a = 4V + 2c - P,   b = 8c + 2V + Kh - 2D
                     the column's  a + b - s (a - b)

Each kernel is exact for flat colours and for colours that change linearly with the same slope.

Blending the four samples bilinearly cuts off crests. What is added to all three colours for that,
in 64ths of a grey level, with the middle d of rows and columns 2 and 3 and the pixel's position
(fx, fy) between the samples::

    crest = -strength (n(fx) (d2 + d3 along rows) + n(fy) (d2 + d3 along columns))
    n(f)  = 0, 1, 2, 2, 3, 3, 4, 4 by eighths of the smaller one of 2 f and 2 (1 - f)

``strength`` is 0 (none), 1 or 2.
"""

import numpy as np

__all__ = ["crest_of", "directional_colours", "twice_direction"]

_DROPPED = 2            # lowest bits of a sample that the decision ignores
_BIAS = 8               # by which one direction must be better
_CREST = np.array([0, 1, 2, 2, 3, 3, 4, 4])
_AT = {"H": ((0, -1), (0, 1)), "V": ((-1, 0), (1, 0)), "Q": ((0, -2), (0, 2)),
       "P": ((-2, 0), (2, 0)), "D": ((-1, -1), (-1, 1), (1, -1), (1, 1)),
       "Kv": ((-2, -1), (-2, 1), (2, -1), (2, 1)), "Kh": ((-1, -2), (-1, 2), (1, -2), (1, 2))}


def _differences(window):
    """d along the rows of windows (..., 6, 6) of coarse samples: (..., 6, 3)."""
    return window[..., :3] - window[..., 1:4] - window[..., 2:5] + window[..., 3:]


def _coarse(window):
    """The bits of raw windows that the decision and the crest look at."""
    return window.astype(np.int64) >> _DROPPED


def _variation(window):
    """h of windows (..., 6, 6) of coarse samples; v is that of the transposed windows."""
    d = _differences(window)
    m = np.where(d < 0, -d - 1, d)
    return m[..., 2:4, :].sum((-2, -1)) + m[..., 1, 1] + m[..., 4, 1]


def twice_direction(window):
    """2 s of raw windows (..., 6, 6), integers of -2..2, as of the module."""
    coarse = _coarse(window)
    h, v = _variation(coarse), _variation(coarse.swapaxes(-1, -2))
    return (np.select([2 * h + _BIAS <= v, 4 * h + _BIAS <= 3 * v], [2, 1], 0)
            - np.select([2 * v + _BIAS <= h, 4 * v + _BIAS <= 3 * h], [2, 1], 0))


def _times(twice, value):
    """s ``value`` for ``twice`` 2 s, as of the module."""
    return np.sign(twice) * np.where(np.abs(twice) == 1, value >> 1, value)


def directional_colours(window, x0, y0, phase):
    """Four colours of each 6x6 raw ``window`` (..., 6, 6), shape (2, 2, 3, ...).

    Colour (j, i) belongs to the sample in row 2 + j, column 2 + i of the window. Colours are in
    units of a sixteenth; they are not clamped. ``phase``: (column, row) parity of the red samples;
    ``x0``, ``y0``: column and row of the first sample in the frame.
    """
    window = window.astype(np.int64)
    right, below = (np.asarray(x0) + phase[0]) & 1, (np.asarray(y0) + phase[1]) & 1
    twice = twice_direction(window)
    colours = np.empty((2, 2, 3, *window.shape[:-2]), np.int64)
    for j in range(2):
        for i in range(2):
            c = window[..., 2 + j, 2 + i]
            around = {name: sum(window[..., 2 + j + y, 2 + i + x] for y, x in at)
                      for name, at in _AT.items()}
            green, other = _at_chroma(c, around, twice)
            across = _at_green(c, around, "H", "Q", "Kv", twice)
            down = _at_green(c, around, "V", "P", "Kh", -twice)
            own = 16 * c
            red_row, red_column = (below + j) % 2 == 0, (right + i) % 2 == 0
            colours[j, i, 0] = np.where(red_row, np.where(red_column, own, across),
                                        np.where(red_column, down, other))
            colours[j, i, 1] = np.where(red_row == red_column, green, own)
            colours[j, i, 2] = np.where(red_row, np.where(red_column, other, down),
                                        np.where(red_column, across, own))
    return colours


def _at_chroma(c, around, twice):
    """Green and the other chroma at a red or blue sample ``c``."""
    h, v, q, p, d = (around[name] for name in "HVQPD")
    t = 4 * c - p - q
    step = _times(twice, 3 * (h - v) - (q - p))
    return 4 * (h + v) + t + (t >> 1) + step, 4 * d + 2 * t + 2 * step


def _at_green(c, around, near, far, knights, twice):
    """The chroma at a green sample ``c`` whose neighbours, in the line of ``near``, have it."""
    a = 4 * around[near] + 2 * c - around[far]
    b = 8 * c + 2 * around[near] + around[knights] - 2 * around["D"]
    return a + b + _times(twice, a - b)


def crest_of(window, fx, fy, f_bits, strength):
    """What is added to the colours of a pixel at (fx, fy), fractions of ``f_bits`` bits, in 64ths.

    ``window``: raw windows (..., 6, 6); ``strength``: 0, 1 or 2.
    """
    coarse = _coarse(window)
    along, down = (_differences(each)[..., 2:4, 1].sum(-1)
                   for each in (coarse, coarse.swapaxes(-1, -2)))
    return -strength * (_weight(fx, f_bits) * along + _weight(fy, f_bits) * down)


def _weight(fraction, f_bits):
    """n of the module: by the bits below the highest one, inverted in the upper half."""
    fraction = np.asarray(fraction)
    upper = fraction >> f_bits - 1
    return _CREST[(fraction ^ -upper & (1 << f_bits) - 1) << 4 >> f_bits]
