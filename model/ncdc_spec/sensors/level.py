"""Samples of a sensor made bytes: black level, gains, and a curve of straight pieces."""

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.raw_gains import gained
from ncdc_spec.white_balance import UNITY

__all__ = ["CURVE_BITS", "LINEAR", "PIECES", "SAMPLE_BITS", "check_curve", "levelled"]

SAMPLE_BITS = 12                        # a sensor with fewer has its samples at the top
PIECES = 16                             # of the curve, each of 256 sample values
CURVE_BITS = 9                          # of a node: 0..256
LINEAR = tuple(16 * k for k in range(PIECES + 1))
"""The curve that only rounds: (sample + 8) / 16."""

_PIECE_BITS = SAMPLE_BITS - 4


def check_curve(curve):
    """Raises :class:`InputError` unless ``curve`` is 17 integers of 0..256."""
    if len(curve) != PIECES + 1:
        raise InputError(f"the curve has {len(curve)} nodes, it must have {PIECES + 1}")
    for value in curve:
        if not 0 <= value <= 256 or value != int(value):
            raise InputError(f"a node of the curve is {value}, it must be an integer of 0 to 256")


def levelled(samples, black=0, curve=LINEAR, gains=UNITY):
    """Bytes of ``samples``, integers of 0..4095.

    With d = min(4095 - black, floor((gain max(0, sample - black) + 128) / 256)), piece
    k = floor(d / 256) and f = d mod 256:
    min(255, floor((256 curve[k] + f (curve[k + 1] - curve[k]) + 128) / 256)).
    A sample of all ones is white before black is taken off; the curve can give it back its 255.
    With gains from 1.0 on, it is 4095 - black in all colours.

    Parameters
    ----------
    samples : array of int
    black : int
        0..4095.
    curve : sequence of int
        17 nodes of 0..256.
    gains : int or array of int
        Gain in 256ths of all samples, or of each: see :func:`ncdc_spec.raw_gains.sample_gains`.

    Raises
    ------
    InputError
        If the curve is none.
    """
    check_curve(curve)
    above = np.maximum(0, np.asarray(samples, np.int64) - black)
    d = gained(above, gains, (1 << SAMPLE_BITS) - 1 - black)
    k, f = d >> _PIECE_BITS, d & (1 << _PIECE_BITS) - 1
    nodes = np.asarray(curve, np.int64)
    value = (nodes[k] << 8) + f * (nodes[k + 1] - nodes[k]) + 128 >> 8
    return np.minimum(255, value).astype(np.uint8)
