"""The ``table`` tan-sigmoid: quadratics fitted with exact values, results in plain loops."""

from dataclasses import replace
from math import exp, tanh

import mpmath
import numpy as np
import pytest

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.tansig.table import TableDesign

PUBLISHED = {16: ((3, 2, 1), 26, 22), 18: ((4, 3, 1), 29, 24), 20: ((4, 3, 1), 31, 26),
             22: ((5, 4, 2), 32, 28)}


class Loose(TableDesign):
    """Whose bound is not computed."""

    def _bound(self):
        return 0.0


SMALL = Loose(Q(4, 9), 10, (4, 3, 1), 20, 15)


def segments_of(d):
    """(first raw magnitude, width) of each segment: a quarter, a quarter and half of the range."""
    end = 1 << d.input.i_bits + d.input.f_bits - 1
    found, start = [], 0
    while start < end:
        bits = d.segment_bits[0 if start < end // 4 else 1 if start < end // 2 else 2]
        found.append((start, 1 << d.input.f_bits - bits))
        start += found[-1][1]
    return found


def fitted(d, start, width):
    """(value, slope, curvature) of a segment, by the third difference of the exact function.

    Equal errors of alternating sign at t = 0, 1/4, 3/4 and 1; in the first segment at the last
    three, after the first zero of the Chebyshev cubic is moved to 0, where the error is 0.
    """
    with mpmath.workdps(50):
        mpf, root = mpmath.mpf, mpmath.sqrt(3)
        nodes = [mpf(0), mpf(1) / 4, mpf(3) / 4, mpf(1)]
        if not start:
            # Zeros of the cubic on [0, 1] are 1/2 and 1/2 +- sqrt(3) / 4.
            zero = mpf(1) / 2 - root / 4
            nodes = [mpf(0), *((t - zero) / (1 - zero) for t in nodes[1:])]
        f = [mpmath.tanh((start + t * width) / mpf(2)**(d.input.f_bits + 1)) for t in nodes]
        signs = [mpf((-1)**k) for k in range(4)] if start else [mpf(0), 1, -1, 1]

        def third_difference(values):
            return sum(value / mpmath.fprod(t - other for other in nodes if other != t)
                       for value, t in zip(values, nodes))
        error = third_difference(f) / third_difference(signs)
        p0, p1, _, p3 = (value - sign * error for value, sign in zip(f, signs))
        # p0 + t slope - t^2 curvature through three of the four.
        t = nodes[1]
        exact_curvature = ((p1 - p0) / t - (p3 - p0)) / (1 - t)
        exact_slope = p3 - p0 + exact_curvature
        scale = mpf(2)**d.slope_bits
        curvature = int(mpmath.nint(exact_curvature * scale))
        slope = int(mpmath.nint((exact_slope - exact_curvature) * scale + curvature))
        left = [y - x * (slope - x * curvature) / scale for x, y in zip(nodes, f)]
        value = int(mpmath.nint((max(left) + min(left)) / 2 * mpf(2)**d.offset_bits))
        return (value if start else 0), slope, curvature


def result(d, row, offset, width):
    """Twice the quadratic, floored to P fraction bits, and one more."""
    value, slope, curvature = row
    position = d.input.f_bits - min(d.segment_bits)
    t = (offset << position) // width
    steepness = slope - (curvature * t >> position)
    below = d.slope_bits + position
    total = (value << below - d.offset_bits) + t * steepness
    return 2 * min(total >> below - d.fraction_bits, (1 << d.fraction_bits) - 1) + 1


def test_the_small_design_in_plain_loops():
    d, segments = SMALL, segments_of(SMALL)
    assert d.segments == segments and d.entries == len(segments) == 32 + 16 + 8
    assert d.ranges == ((0, 0, 5), (32, 1024, 6), (48, 2048, 8)) and d.position_bits == 8
    assert d.coefficients == d.fitted == tuple(fitted(d, *segment) for segment in segments)
    assert {type(number) for row in d.fitted for number in row} == {int}
    widths = tuple(max(row[k] for row in d.fitted).bit_length() for k in range(3))
    assert d.coefficient_bits == widths and d.table_bits == 56 * sum(widths)
    assert (d.multipliers, d.adders, d.stages, d.variant) == (2, 3, 5, "table")
    want = [result(d, row, offset, width) for row, (_, width) in zip(d.fitted, segments)
            for offset in range(width)]
    a = np.arange(d.input.hi + 1)
    assert d.magnitude(a).tolist() == want and d.largest == want[-1]
    entry, t = d.locate(a)
    assert entry.tolist() == [k for k, (_, width) in enumerate(segments) for _ in range(width)]
    assert t.tolist() == [(offset << 8) // width for _, width in segments
                          for offset in range(width)]
    for entry, change in ((0, 3), (7, -40), (40, 9), (55, 200)):
        value, *others = d.fitted[entry]
        width = segments[entry][1]
        moved = [result(d, (value + change, *others), offset, width) for offset in range(width)]
        assert d.changed_entry(entry, change).tolist() == (moved if entry else [0, *moved[1:]])
    assert result(d, (d.fitted[55][0] + 200, *d.fitted[55][1:]), 255, 256) == 2**11 - 1


def test_tables_are_made_once():
    assert SMALL.fitted is SMALL.fitted and SMALL.coefficients is SMALL.coefficients
    assert (Loose().segment_bits, Loose().slope_bits, Loose().offset_bits) == PUBLISHED[20]
    with pytest.raises(AttributeError):
        SMALL.slope_bits = 5


@pytest.mark.parametrize("parameters,message", [
    ((Q(5, 8), 6, (3, 2, 2), 20, 15), r"are \(3, 2, 2\), they must fall, below 8, for an input of"),
    ((Q(5, 8), 6, (3, 3, 1), 20, 15), r"are \(3, 3, 1\), they must fall, below 8"),
    ((Q(5, 8), 6, (3, 1, 2), 20, 15), r"are \(3, 1, 2\), they must fall, below 8"),
    ((Q(5, 8), 6, (3, 4, 1), 20, 15), r"are \(3, 4, 1\), they must fall, below 8"),
    ((Q(5, 8), 6, (8, 2, 1), 20, 15), r"are \(8, 2, 1\), they must fall, below 8"),
    ((Q(5, 8), 6, (9, 2, 1), 20, 15), r"are \(9, 2, 1\), they must fall, below 8"),
    ((Q(1, 8), 6, (3, 2, 1), 20, 15), "for an input of 3 integer bits or more"),
    ((Q(2, 8), 6, (3, 2, 1), 20, 15), "for an input of 3 integer bits or more"),
    ((Q(5, 8), 6, (3, 2, 1), 20, 6), "offset_bits is 6, the limits are 7 and 27"),
    ((Q(5, 8), 6, (3, 2, 1), 20, 5), "offset_bits is 5, the limits are 7 and 27"),
    ((Q(5, 8), 6, (3, 2, 1), 20, 29), "offset_bits is 29, the limits are 7 and 27"),
    ((Q(5, 8), 6, (3, 2, 1), 20, 28), "offset_bits is 28, the limits are 7 and 27")])
def test_limits_of_the_parameters(parameters, message):
    with pytest.raises(InputError, match=message):
        Loose(*parameters)


@pytest.mark.parametrize("parameters", [
    (Q(3, 8), 6, (7, 2, 1), 20, 7), (Q(5, 8), 6, (3, 2, 1), 20, 27)])
def test_parameters_at_their_limits(parameters):
    d = Loose(*parameters)
    assert d.segments == segments_of(d)


@pytest.mark.parametrize("bits", PUBLISHED)
def test_published_parameters(bits):
    assert Loose.for_bits(bits) == Loose(Q(5, 19), bits, *PUBLISHED[bits])
    assert set(Loose._DEFAULTS) == set(PUBLISHED)


@pytest.mark.parametrize("parameters", [
    (Q(4, 9), 10, (4, 3, 1), 20, 15), (Q(3, 10), 7, (2, 1, 0), 15, 12)])
def test_the_bound_is_the_sum_of_its_parts(parameters):
    """Half a unit of the last bit, the largest error of a quadratic, and the cut product."""
    d = TableDesign(*parameters)
    worst, points = 0, 256
    for (start, width), (value, slope, curvature) in zip(segments_of(d), d.coefficients):
        h, first = width / 2**d.input.f_bits, start / 2**d.input.f_bits
        errors = []
        for k in range(points + 1):
            t = k / points
            quadratic = value / 2**d.offset_bits + t * (slope - t * curvature) / 2**d.slope_bits
            errors.append(abs(quadratic - tanh((first + t * h) / 2)))
        # A curve f'' h^2 / 8 between samples, where f'' <= h f'''.
        between = min(1 / 4, 2 * exp(-first)) * h * (h / points)**2 / 8
        worst = max(worst, max(errors) + between)
    assert d.bound_ulp == pytest.approx(
        .5 + (worst + 2.0**-d.slope_bits) * 2**d.fraction_bits, rel=1e-11)
    a = np.arange(d.input.hi + 1)
    largest = np.abs(d.magnitude(a) / 2.0**(d.fraction_bits + 1)
                     - np.tanh(a / 2.0**(d.input.f_bits + 1))).max() * 2**d.fraction_bits
    assert .5 < largest < d.bound_ulp < 1.2 * largest


def drop(d, segments, entry, rows):
    """Whether a result decreases in the part of an entry, or where it meets its neighbours."""
    width = segments[entry][1]
    part = np.arange(width)
    position = d.input.f_bits - min(d.segment_bits)
    t, (value, slope, curvature) = (part << position) // width, rows[entry]
    below = d.slope_bits + position
    q = 2 * np.minimum((value << below - d.offset_bits) + t * (slope - (curvature * t >> position))
                       >> below - d.fraction_bits, (1 << d.fraction_bits) - 1) + 1
    ends = [result(d, rows[entry - 1], segments[entry - 1][1] - 1, segments[entry - 1][1])]
    if entry + 1 < len(rows):
        q = np.append(q, result(d, rows[entry + 1], 0, segments[entry + 1][1]))
    return bool((np.diff(np.append(ends, q)) < 0).any())


@pytest.mark.longer
@pytest.mark.parametrize("bits", PUBLISHED)
def test_few_values_are_changed_and_each_is_needed(bits):
    """With a change a step closer to none, a result decreases. It does with the opposite of a
    change upwards: downwards is preferred."""
    d = Loose.for_bits(bits)
    segments, rows = segments_of(d), [list(row) for row in d.coefficients]
    plain = [list(row) for row in d.fitted]
    assert [row[1:] for row in rows] == [row[1:] for row in plain]
    changed = {k: a[0] - b[0] for k, (a, b) in enumerate(zip(rows, plain)) if a != b}
    assert len(changed) == {16: 12, 18: 5, 20: 5, 22: 10}[bits]
    for k, off in changed.items():
        assert not drop(d, segments, k, rows)
        closer = [row[:] for row in rows]
        closer[k][0] -= 1 if off > 0 else -1
        assert drop(d, segments, k, closer)
        closer[k][0] = rows[k][0] - 2 * off
        assert off < 0 or drop(d, segments, k, closer)
    assert replace(d, input=Q(5, 18)).coefficients == replace(d, input=Q(5, 18)).fitted
