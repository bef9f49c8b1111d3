"""Division by linear vectoring CORDIC: digits in plain integers, bounds by enumeration."""

from fractions import Fraction

import numpy as np
import pytest

from ncdc_spec.tansig.lvc import (
    _worst_pattern,
    largest_rounding,
    quotient,
    quotient_error,
    round_shift,
)


def half_up(value, shift):
    """``value`` / 2**``shift`` to the nearest integer, halves up."""
    return (Fraction(value, 1 << shift) + Fraction(1, 2)).__floor__()


def distance(value):
    """Distance of a fraction to the nearest integer."""
    return abs(value - round(value))


def test_shifts_round_halves_up():
    values = np.arange(-40, 41)
    for shift in (1, 2, 3, 5):
        assert round_shift(values, shift).tolist() == [half_up(v, shift) for v in values.tolist()]


@pytest.mark.parametrize("width,digits", [(9, 6), (12, 14), (25, 21)])
def test_digits_of_the_quotient(width, digits):
    one = 1 << width
    u = np.append(np.random.default_rng(1).integers(0, one, 60), [0, 1, one // 3, one - 1, one,
                                                                  one + 5])
    before = u.copy()
    got = quotient(u, width, digits)
    np.testing.assert_array_equal(u, before)
    for each, raw in zip(u.tolist(), got.tolist()):
        remainder, total = one - each, 0
        for i in range(1, digits + 1):
            sign = 1 if remainder >= 0 or i == 1 else -1
            total += sign << (digits - i)
            remainder -= sign * half_up(one + each, i)
        assert raw == total and raw % 2
    exact = (one - u[:-1]) / (one + u[:-1])
    # Half a unit of the last digit, and a half of a unit of the width for each rounded divisor.
    assert (np.abs(got[:-1] / 2.0**digits - exact) <= 2.0**-digits + digits / 2 / one).all()


def test_the_largest_distance_to_an_integer():
    eighths = np.arange(-12, 13)
    lo, hi = (a.ravel() for a in np.meshgrid(eighths, eighths))
    lo, hi = lo[lo <= hi], hi[lo <= hi]
    want = [max(distance(Fraction(n, 8)) for n in range(a, b + 1)) for a, b in zip(lo, hi)]
    np.testing.assert_array_equal(largest_rounding(lo / 8, hi / 8), np.array(want, float))


def test_the_worst_pattern_of_low_bits():
    def largest(bits):
        return max(sum(distance(Fraction(x, 1 << i)) for i in range(1, bits + 1))
                   for x in range(1 << bits))
    for bits in range(8):
        assert _worst_pattern(bits) == largest(bits)
    x, units = np.arange(1 << 16), 0                # of 2**-16
    for i in range(1, 17):
        low = x % (1 << i)
        units = units + (np.minimum(low, (1 << i) - low) << 16 - i)
    assert _worst_pattern(16) == units.max() / 2**16
    assert _worst_pattern(17) == _worst_pattern(16) + .5
    assert _worst_pattern(19) == _worst_pattern(16) + 1.5


def bound_by_loops(lo, hi, width, digits):
    """The docstring's bound: the roundings of the divisor's shifts, low ones by the pattern."""
    one = 1 << width
    narrow = max(max(b - a for a, b in zip(lo, hi)), 1)
    low = 0
    while 1 << low < narrow:                        # shifts whose rounded bits are arbitrary
        low += 1
    low = min(low, digits - 1)
    found = []
    for a, b in zip(lo, hi):
        total = Fraction(_worst_pattern(low)) + max(b - one, 0)
        for i in range(low + 1, digits):
            ends = Fraction(one + a, 1 << i), Fraction(one + b, 1 << i)
            half = ((ends[0] - Fraction(1, 2)).__ceil__() + Fraction(1, 2))
            total += Fraction(1, 2) if half <= ends[1] else max(map(distance, ends))
        found.append(float(total / (1 + Fraction(max(a, 0), one))))
    return found


@pytest.mark.parametrize("spread", [0, 1, 2, 5, 200, 1 << 14])
@pytest.mark.parametrize("width,digits", [(12, 9), (14, 6)])
def test_the_quotients_bound(width, digits, spread):
    rng = np.random.default_rng(spread)
    lo = np.append(rng.integers(0, 1 << width, 30), [0, -3, (1 << width) - 2, (1 << width) + 3])
    hi = lo + spread
    got = quotient_error(lo.astype(float), hi.astype(float), width, digits)
    np.testing.assert_allclose(got, bound_by_loops(lo.tolist(), hi.tolist(), width, digits),
                               rtol=1e-14)
    if spread < 100:
        u = np.clip(np.stack([lo, hi]), 0, None)
        exact = ((1 << width) - u) / ((1 << width) + u)
        error = np.abs(quotient(u, width, digits) / 2.0**digits - exact) - 2.0**-digits
        assert (error[:, lo >= 0] * 2.0**width <= got[lo >= 0] + 1e-9).all()
