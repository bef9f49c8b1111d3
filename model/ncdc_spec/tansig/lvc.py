"""Linear vectoring CORDIC (LVC): the quotient (1 - u) / (1 + u), and a bound of its error."""

from functools import cache

import numpy as np

__all__ = ["largest_rounding", "quotient", "quotient_error", "round_shift"]


def round_shift(value, shift):
    """``value`` >> ``shift``, rounded: the last bit shifted out is added."""
    return (value + (1 << (shift - 1))) >> shift


def quotient(u, width, digits):
    """(1 - u) / (1 + u) with ``digits`` digits +-2**-i, the first positive.

    ``u``: raw with ``width`` fraction bits. Returns the raw quotient with ``digits`` fraction
    bits, which is odd.
    """
    one = 1 << width
    remainder, divisor = one - u, one + u
    result = np.zeros_like(u)
    for i in range(1, digits + 1):
        plus = (remainder >= 0) | (i == 1)
        step = round_shift(divisor, i)
        remainder += np.where(plus, -step, step)
        result += np.where(plus, 1, -1) << (digits - i)
    return result


def largest_rounding(lo, hi):
    """Largest distance to the nearest integer on each interval [lo, hi]."""
    near = np.maximum(np.abs(lo - np.round(lo)), np.abs(hi - np.round(hi)))
    return np.where(np.floor(hi - .5) >= np.ceil(lo - .5), .5, near)


def quotient_error(lo, hi, width, digits):
    """Bound of :func:`quotient`'s error, without half a unit of its last digit, u in [lo, hi].

    ``lo``, ``hi``: arrays of equal shape, raw with ``width`` fraction bits. Returns |error| of
    the quotient times 2**width.

    Let x = 1 + u, r(i) the exact remainder after the digits d(1..i), and E(i) the sum of
    d(j) rho(j) up to i, where rho(j) is the rounding of x >> j. The digit i + 1 has the wrong sign
    only where \\|r(i)\\| <= \\|E(i)\\|, so that by induction
    \\|r(i)\\| <= x 2**-i + max \\|E(j)\\|, j < i. The quotient's error is
    \\|r(digits)\\| / x <= 2**-digits + max \\|E(j)\\| / x. The roundings of the low shifts
    depend on low bits of x, which are arbitrary: the worst pattern counts. Those of the high
    shifts follow from the interval.
    """
    narrow = max(float((hi - lo).max()), 1)
    low = min(int(np.ceil(np.log2(narrow))), digits - 1)
    one = 1 << width
    total = _worst_pattern(low) + np.maximum(hi - one, 0)     # u > 1: the first digit is wrong
    for i in range(low + 1, digits):
        total = total + largest_rounding((one + lo) / 2.0**i, (one + hi) / 2.0**i)
    return total / (1 + np.maximum(lo, 0) / one)


@cache
def _worst_pattern(bits):
    """Largest sum of the distances of x / 2**i to an integer, i = 1..bits, over integers x.

    The distance of x / 2**i depends on i low bits of x: patterns of up to 16 bits are enumerated,
    and each further bit adds at most a half.
    """
    x = np.arange(1 << min(bits, 16))
    total = sum((np.abs(x / 2.0**i - np.round(x / 2.0**i)) for i in range(1, min(bits, 16) + 1)),
                start=np.zeros(len(x)))
    return float(total.max()) + max(bits - 16, 0) / 2
