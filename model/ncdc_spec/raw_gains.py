"""White balance of raw frames, before interpolation: the gain of each sample, and its product."""

import numpy as np

from ncdc_spec.white_balance import GAIN_F_BITS, UNITY

__all__ = ["NO_RAW_GAINS", "balanced_raw", "frame_gains", "gained", "sample_gains"]

NO_RAW_GAINS = (UNITY,) * 3


def sample_gains(size, phase, gains):
    """Gain of each raw sample, by the colour of its filter.

    Parameters
    ----------
    size : (int, int)
        Width and height of the raw frame.
    phase : (int, int) or None
        Parity of column and row of the red samples; None for a grey sensor, whose samples have
        the gain of green.
    gains : sequence of int
        Gains of red, green and blue in 256ths.

    Returns
    -------
    ndarray of int64, shape (height, width)
    """
    red, green, blue = gains
    found = np.full(size[::-1], green, np.int64)
    if phase is not None:
        column, row = phase
        found[row::2, column::2] = red
        found[1 - row::2, 1 - column::2] = blue
    return found


def frame_gains(geometry, gains):
    """:func:`sample_gains` of the raw frames of a camera of ``geometry``."""
    return sample_gains(geometry.distorted, None if geometry.mono else geometry.phase, gains)


def gained(samples, gains, most):
    """min(most, floor((gain sample + 128) / 256)) of integer ``samples``, int64.

    ``gains`` are in 256ths, one for each sample or one for all. With gains from 1.0 on, samples
    that are full in all colours become ``most`` in all colours: they stay white.
    """
    products = np.asarray(samples, np.int64) * gains
    return np.minimum(most, products + (1 << GAIN_F_BITS - 1) >> GAIN_F_BITS)


def balanced_raw(raw, geometry, gains):
    """The ``raw`` uint8 frame of a camera of ``geometry`` after ``gains``, as tiles hold it."""
    if tuple(gains) == NO_RAW_GAINS:
        return raw
    return gained(raw, frame_gains(geometry, gains), 255).astype(np.uint8)
