"""An even Bayer grid out of the uneven one that a sensor sends when it skips or bins.

Such a sensor reduces each axis by s and keeps the Bayer pattern: of every 2 s active pixels it
sends two samples, the first two pixels, or the means of the same-coloured ones. The samples of such
a pair lie 1 active pixel apart instead of s. Around the middle of all pairs an even grid has its
samples at s i + (1 - s) / 2. A sample with an even index lies d = (s - 1) / 2 active pixels
after that position, one with an odd index d before it.

:func:`evened` moves each sample by d, along rows and then along columns. Samples are integers of 12
bits, with the black level still in them.
"""

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.level import SAMPLE_BITS

__all__ = ["MAX_REDUCTION", "MAX_WEIGHT", "binned", "evened", "grid_size", "grid_weight",
           "gridded"]

MAX_REDUCTION = 7
MAX_WEIGHT = 3                          # sixteenths; no reduction needs 4
_WHITE = (1 << SAMPLE_BITS) - 1
_SHIFT = 7                              # the sum of evening is in 128ths
_UNMOVED = 2                            # first samples of a line, without neighbours before them


def grid_weight(reduction):
    """Weight in sixteenths for a sensor, and capture's own binning, that reduce by ``reduction``.

    d of the 2 s active pixels from a sample to the next one of its colour: 16 (s - 1) / (4 s),
    rounded to nearest. 1 gives 0, 2 gives 2, 4 gives 3.

    Raises
    ------
    InputError
        Unless ``reduction`` is an integer of 1 to 7.
    """
    if reduction != int(reduction) or not 1 <= reduction <= MAX_REDUCTION:
        raise InputError(f"the reduction is {reduction}, it must be an integer of 1 to "
                         f"{MAX_REDUCTION}")
    return int((8 * (reduction - 1) + reduction) // (2 * reduction))


def grid_size(size, weight, binning):
    """(width, height) of what :func:`gridded` makes of ``size``, (width, height)."""
    return tuple(_evened_length(_binned_length(length, binning), weight) for length in size)


def gridded(samples, weight, binning):
    """What capture's grid stage makes of a frame: :func:`binned` if ``binning``, then
    :func:`evened`."""
    return evened(binned(samples) if binning else _checked(samples), weight)


def binned(samples):
    """Half the samples of a frame along either axis, in the same Bayer pattern.

    Along each axis the samples 4 k and 4 k + 2 make sample 2 k, and 4 k + 1 and 4 k + 3 make
    2 k + 1; so each result is a mean of four, (sum + 2) // 4. A sample whose partner was not sent
    is dropped: n samples make 2 (n // 4), and one more if n % 4 = 3.

    Parameters
    ----------
    samples : ndarray of integers, shape (height, width)

    Returns
    -------
    ndarray of int64
    """
    sums = _checked(samples)
    for axis in (0, 1):
        first = np.flatnonzero(np.arange(sums.shape[axis]) % 4 < 2)
        first = first[:_binned_length(sums.shape[axis], True)]
        sums = np.take(sums, first, axis) + np.take(sums, first + 2, axis)
    return sums + 2 >> 2


def evened(samples, weight):
    """The samples of an even grid, each by five samples of its line around it.

    With x[0] the sample, x[1], x[2] the next ones in the direction in which it is moved, and x[-1],
    x[-2] those on the other side, it becomes

        (128 x[0] + weight (4 (x[1] - x[-1]) + 2 (x[0] - x[-2]) + (x[2] - x[-2])) + 64) // 128

    within 0 .. 4095. An even index is moved towards lower ones, an odd one towards higher ones. The
    neighbours of the other colour measure the slope nearest to the sample, those of its own colour
    keep it sharp. On a plane of grey, whatever its slope, the result is exact but for rounding.

    First each row becomes such, with its roundings, then each column of the result. The first two
    samples of a row or column keep their values; the last two are dropped, as they lack neighbours.
    A weight of 0 leaves the frame as it is, at its size.

    Parameters
    ----------
    samples : ndarray of integers of 0..4095, shape (height, width)
    weight : int
        0 to 3, see :func:`grid_weight`.

    Returns
    -------
    ndarray of int64, shape (height - 2, width - 2)

    Raises
    ------
    InputError
        If a sample or the weight is out of its range.
    """
    samples = _checked(samples)
    if weight != int(weight) or not 0 <= weight <= MAX_WEIGHT:
        raise InputError(f"the grid weight is {weight}, it must be an integer of 0 to {MAX_WEIGHT}")
    if not weight:
        return samples
    return _moved(_moved(samples.T, int(weight)).T, int(weight))


def _moved(lines, weight):
    """``lines`` (n, ...) moved along their first axis, of which the last two are dropped."""
    count = _evened_length(len(lines), weight)
    result = lines[:count].copy()
    for parity, step in ((0, -1), (1, 1)):
        at = np.arange(_UNMOVED + parity, count, 2)
        before, beyond, own, after, far = (lines[at + k * step] for k in (-1, -2, 0, 1, 2))
        move = 4 * (after - before) + 2 * (own - beyond) + (far - beyond)
        total = (own << _SHIFT) + weight * move + (1 << _SHIFT - 1)
        result[at] = np.clip(total >> _SHIFT, 0, _WHITE)
    return result


def _checked(samples):
    samples = np.asarray(samples, np.int64)
    if samples.ndim != 2:
        raise InputError(f"a frame of samples has 2 axes, this one has {samples.ndim}")
    if samples.size and not 0 <= samples.min() <= samples.max() <= _WHITE:
        raise InputError(f"samples of {samples.min()} to {samples.max()}, they must be of 0 to "
                         f"{_WHITE}")
    return samples


def _binned_length(length, binning):
    return length // 4 * 2 + (length % 4 == 3) if binning else length


def _evened_length(length, weight):
    return max(0, length - 2) if weight else length
