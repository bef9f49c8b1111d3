"""Piecewise linear tone curves, with short pieces near black, and named curves."""

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.tone import NODE_POSITIONS

__all__ = ["GAMMA_LIMITS", "exact_tone", "toned", "tone_named"]


GAMMA_LIMITS = (1.0, 3.0)
_LONGEST = 6                            # log2 of the longest piece
_STEPS = (-2, -1, 1, 2)                 # of a node in the search
_VALUES = np.arange(256)


def toned(values, nodes):
    """``values``, integers of 0..255, by the curve through ``nodes``; uint8.

    With the piece k that holds v, of the length L = NODE_POSITIONS[k + 1] - NODE_POSITIONS[k], and
    f = 64 (v - NODE_POSITIONS[k]) / L, an integer of 0..63:
    min(255, floor((64 nodes[k] + f (nodes[k + 1] - nodes[k]) + 32) / 64)).
    """
    values, nodes = np.asarray(values, np.int64), np.asarray(nodes, np.int64)
    positions = np.array(NODE_POSITIONS)
    piece = np.searchsorted(positions, values, side="right") - 1
    length = positions[piece + 1] - positions[piece]
    offset = (values - positions[piece] << _LONGEST) // length
    rise = offset * (nodes[piece + 1] - nodes[piece])
    total = (nodes[piece] << _LONGEST) + rise + (1 << _LONGEST - 1)
    return np.minimum(255, total >> _LONGEST).astype(np.uint8)


def exact_tone(name, values=_VALUES):
    """Real values, 0..255, of the tone curve ``name`` without pieces.

    "linear": v; "sRGB": IEC 61966-2-1, from linear light to code values; "gamma:G":
    255 (v / 255)**(1 / G), G within GAMMA_LIMITS.

    Raises
    ------
    InputError
        If there is no such curve.
    """
    x = np.asarray(values, float) / 255
    if name.lower() == "linear":
        return 255 * x
    if name.lower() == "srgb":
        # Near black the power is not used, but must not fail.
        return 255 * np.where(x <= .0031308, 12.92 * x, 1.055 * x ** (1 / 2.4) - .055)
    return 255 * x ** (1 / _gamma(name))


def _gamma(name):
    """G of the curve "gamma:G"."""
    kind, _, text = name.partition(":")
    if kind.lower() != "gamma":
        raise InputError(f"the tone is {name!r}, one of linear, sRGB, gamma:G is needed")
    try:
        gamma = float(text)
    except ValueError:
        raise InputError(f"the gamma of the tone is {text!r}, a number is needed") from None
    low, high = GAMMA_LIMITS
    if not low <= gamma <= high:
        raise InputError(f"the gamma of the tone is {text}, the limits are {low:g} and {high:g}")
    return gamma


def tone_named(name):
    """The 17 nodes whose curve is nearest to the tone curve ``name``, see :func:`exact_tone`.

    The search starts at the nodes on the exact curve. It moves one node at a time while that
    reduces the largest difference from the rounded exact values, or else the sum of squares.
    """
    exact = np.floor(exact_tone(name) + 0.5).astype(np.int64)
    nodes = np.minimum(256, np.floor(exact_tone(name, NODE_POSITIONS) + 0.5)).astype(np.int64)
    best, better = _errors(nodes, exact), True
    while better:
        better = False
        for k in range(len(nodes)):
            for step in _STEPS:
                other = nodes.copy()
                other[k] = min(256, max(0, other[k] + step))
                if (errors := _errors(other, exact)) < best:
                    nodes, best, better = other, errors, True
    return tuple(nodes.tolist())


def _errors(nodes, exact):
    """Largest difference of the curve from ``exact``, and the sum of squares."""
    difference = np.abs(toned(_VALUES, nodes) - exact)
    return int(difference.max()), int((difference ** 2).sum())
