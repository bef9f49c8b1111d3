"""The ``mmhbc`` tan-sigmoid compared with plain loops, its table with exact exponentials."""

from dataclasses import replace

import mpmath
import numpy as np
import pytest

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.tansig.mmhbc import TansigDesign

PUBLISHED = {16: (21, 4), 18: (23, 4), 20: (25, 5), 22: (28, 6)}     # P: W, t


class Loose(TansigDesign):
    """Whose bound is not computed, which takes most of the time."""

    def _bound(self):
        return 0.0


SMALL = Loose(Q(3, 10), 8, 13, 3)


def exact_entry(design, region):
    """exp(-(A 2**-t + c)) / prod(sqrt(1 - 4**-s)), not rounded, raw with W fraction bits."""
    t, f = design.region_bits, design.input.f_bits
    with mpmath.workdps(60):
        halves = [mpmath.mpf(2)**-(m + 1) for m in range(t + 1, f + 1)]     # of the fine bits
        scale = mpmath.mpf(1)
        for half in halves:
            scale *= mpmath.sqrt(1 - half**2)
        return mpmath.exp(-(mpmath.mpf(region) / 2**t + sum(halves))) / scale * 2**design.width


def half_up(value, shift):
    return (value + (1 << shift) // 2) >> shift


def by_digits(u, width, digits):
    """(1 - u) / (1 + u), a digit at a time."""
    one, total = 1 << width, 0
    remainder = one - u
    for i in range(1, digits + 1):
        sign = 1 if remainder >= 0 or i == 1 else -1
        total += sign << (digits - i)
        remainder -= sign * half_up(one + u, i)
    return total


def rotated(u, fine, t, f):
    """``u`` after a rotation for each fine bit, from the highest on: 1 decreases it."""
    for m in range(t + 1, f + 1):
        step = half_up(u, m + 1)
        u += -step if fine >> (f - m) & 1 else step
    return u


def test_the_small_design_in_plain_loops():
    d, (t, f) = SMALL, (3, 10)
    assert d.shifts == (5, 6, 7, 8, 9, 10, 11) and d.fine_bits == 7 and d.digits == 9
    assert d.adders == 1 + 7 + 1 + 8 and d.stages == 7 + 1 + 9 and d.table_bits == 32 * 13
    assert (d.entries, d.multipliers, d.variant) == (32, 0, "mmhbc")
    assert d.rounded_table == d.table == tuple(int(mpmath.nint(exact_entry(d, A)))
                                               for A in range(32))
    assert {type(entry) for entry in d.table} == {int}
    a = np.arange(d.input.hi + 1)
    u = [rotated(d.table[n >> 7], n & 127, t, f) for n in a.tolist()]
    assert d.exponential(a).tolist() == u
    q = [by_digits(each, 13, 9) for each in u]
    assert d.magnitude(a).tolist() == q and d.largest == q[-1]
    for entry, change in ((0, 0), (0, 2), (5, 1), (31, -1)):
        u = [rotated(d.rounded_table[entry] + change, fine, t, f) for fine in range(128)]
        want = [by_digits(each, 13, 9) for each in u]
        assert d.changed_entry(entry, change).tolist() == (want if entry else [0, *want[1:]])
    # The largest error of every input, in units of 2**-8.
    error = np.abs(np.array(q) / 2.0**9 - np.tanh(a / 2.0**11)) * 2**8
    assert error.max() < 1


def test_tables_are_made_once():
    assert SMALL.table is SMALL.table and SMALL.rounded_table is SMALL.rounded_table
    assert Loose().width == 25 and Loose().region_bits == 5
    with pytest.raises(AttributeError):
        SMALL.width = 5


@pytest.mark.parametrize("parameters,message", [
    ((8, 13, 0), "region_bits is 0, the limits are 1 and 9"),
    ((8, 13, 10), "region_bits is 10, the limits are 1 and 9"),
    ((8, 13, 11), "region_bits is 11, the limits are 1 and 9"),
    ((8, 13, -1), "region_bits is -1, the limits are 1 and 9"),
    ((8, 9, 3), "the last rotation shifts by 11, width 9 is the limit"),
    ((8, 10, 3), "the last rotation shifts by 11, width 10 is the limit")])
def test_limits_of_the_parameters(parameters, message):
    with pytest.raises(InputError, match=message):
        Loose(Q(3, 10), *parameters)


def test_parameters_at_their_limits():
    for parameters in ((8, 13, 1), (8, 13, 9), (8, 11, 3)):
        assert Loose(Q(3, 10), *parameters).entries == 1 << 2 + parameters[2]


@pytest.mark.parametrize("bits", PUBLISHED)
def test_published_parameters(bits):
    assert Loose.for_bits(bits) == Loose(Q(5, 19), bits, *PUBLISHED[bits])
    assert set(Loose._DEFAULTS) == set(PUBLISHED)
    d = Loose.for_bits(bits)
    rotations, digits = 19 - d.region_bits, bits + 1
    assert (d.adders, d.stages) == (rotations + digits + 1, rotations + digits + 1)


def test_the_bound_is_computed():
    d = TansigDesign(Q(5, 12), 10, 16, 3)
    a = np.arange(d.input.hi + 1)
    largest = (np.abs(d.magnitude(a) / 2.0**11 - np.tanh(a / 2.0**13)) * 2**10).max()
    assert .5 < largest < d.bound_ulp < min(1, 1.3 * largest)


def decreases(design, entry, change):
    """Whether a result decreases in the part of an entry, or where it meets its neighbours."""
    table = [*design.table]
    table[entry] += change
    t, f = design.region_bits, design.input.f_bits
    fine = np.arange(1 << f - t)
    ends = [by_digits(rotated(table[k], end, t, f), design.width, design.digits)
            for k, end in ((entry - 1, int(fine[-1])), (entry + 1, 0))]
    u = np.full(len(fine), table[entry])
    for m in range(t + 1, f + 1):
        step = half_up(u, m + 1)
        u = np.where(fine >> (f - m) & 1, u - step, u + step)
    # Both neighbours' ends, and this entry's results by the divisor's digits.
    q = by_columns(u, design.width, design.digits)
    return bool((np.diff(np.concatenate([ends[:1], q, ends[1:]])) < 0).any())


def by_columns(u, width, digits):
    """:func:`by_digits` of an array."""
    remainder, total = (1 << width) - u, np.zeros_like(u)
    for i in range(1, digits + 1):
        sign = np.where((remainder >= 0) | (i == 1), 1, -1)
        total += sign << (digits - i)
        remainder -= sign * half_up((1 << width) + u, i)
    return total


@pytest.mark.parametrize("bits,width", [
    (20, 25), *(pytest.param(*each, marks=pytest.mark.longer)
                for each in ((16, 21), (18, 23), (22, 27), (22, 28)))])
def test_few_entries_are_changed_and_each_is_needed(bits, width):
    """An entry is the rounded exponential, or a unit next to it where a result decreases else.

    The unit is subtracted if either does.
    """
    d = Loose(Q(5, 19), bits, width, {16: 4, 18: 4, 20: 5, 22: 6}[bits])
    changed = {}
    for region, entry in enumerate(d.table):
        off = entry - int(mpmath.nint(exact_entry(d, region)))
        if off:
            changed[region] = off
    assert len(changed) == {21: 10, 23: 6, 25: 1, 27: 5, 28: 3}[width]
    for region, off in changed.items():
        assert abs(off) == 1 and not decreases(d, region, 0) and decreases(d, region, -off)
        assert off < 0 or decreases(d, region, -2)
    other = replace(d, input=Q(5, 18))
    assert other.table == other.rounded_table
