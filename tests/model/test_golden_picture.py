"""The back end's integers compared with plain loops over samples and exact fractions."""

from fractions import Fraction
from math import floor

import numpy as np
import pytest

from ncdc_model.golden.directional import directional_colours
from ncdc_model.golden.picture import (
    bayer_quads,
    bilinear,
    corner_colours,
    fetches,
    gradient_colours,
    raw_windows,
    window_address,
)
from ncdc_spec.fixed import Q
from ncdc_spec.geometry import BAYER_PHASE, MONO, Geometry
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT

# Malvar, He, Cutler (2004), fig. 2: eighths by (rows, columns) from the sample.
GREEN_AT_CHROMA = {(0, 0): 4, (-1, 0): 2, (1, 0): 2, (0, -1): 2, (0, 1): 2,
                   (-2, 0): -1, (2, 0): -1, (0, -2): -1, (0, 2): -1}
CHROMA_IN_ROW = {(0, 0): 5, (0, -1): 4, (0, 1): 4, (0, -2): -1, (0, 2): -1, (-1, -1): -1,
                 (-1, 1): -1, (1, -1): -1, (1, 1): -1, (-2, 0): .5, (2, 0): .5}
CHROMA_IN_COLUMN = {(x, y): weight for (y, x), weight in CHROMA_IN_ROW.items()}
CHROMA_AT_CHROMA = {(0, 0): 6, (-1, -1): 2, (-1, 1): 2, (1, -1): 2, (1, 1): 2,
                    (-2, 0): -1.5, (2, 0): -1.5, (0, -2): -1.5, (0, 2): -1.5}

patterns = pytest.mark.parametrize("bayer", BAYER_PHASE)
RNG = np.random.default_rng(11)


def filter_at(bayer, row, column):
    """Letter of the colour filter of a sample; the name of a pattern is its first two rows."""
    return bayer[2 * (row % 2) + column % 2]


def windows_of(side, count=24):
    """Random windows, and first samples in every parity of row and column."""
    return (RNG.integers(0, 256, (count, side, side), np.uint8),
            np.arange(count) % 2 + 4 * np.arange(count), np.arange(count) // 2)


def malvar(window, bayer, row, column, first_row, first_column):
    """Colours in sixteenths of the sample at (row, column) of a window, by the paper's table."""
    def total(kernel):
        return 2 * sum(weight * int(window[row + y, column + x])
                       for (y, x), weight in kernel.items())
    y, x = first_row + row, first_column + column
    here, right = filter_at(bayer, y, x), filter_at(bayer, y, x + 1)
    kernels = {here: {(0, 0): 8}}
    if here == "G":
        kernels |= {right: CHROMA_IN_ROW, {"R": "B", "B": "R"}[right]: CHROMA_IN_COLUMN}
    else:
        kernels |= {"G": GREEN_AT_CHROMA, {"R": "B", "B": "R"}[here]: CHROMA_AT_CHROMA}
    return [total(kernels[colour]) for colour in "RGB"]


@patterns
def test_quads_are_sums_by_colour(bayer):
    windows, x0, y0 = windows_of(3)
    got = bayer_quads(windows, x0, y0, BAYER_PHASE[bayer])
    assert got.dtype == np.int64 and got.shape == (2, 2, 3, len(windows))
    for n, window in enumerate(windows):
        for j in range(2):
            for i in range(2):
                sums = dict.fromkeys("RGB", 0)
                for y in (j, j + 1):
                    for x in (i, i + 1):
                        sums[filter_at(bayer, y0[n] + y, x0[n] + x)] += int(window[y, x])
                assert got[j, i, :, n].tolist() == [2 * sums["R"], sums["G"], 2 * sums["B"]]


@patterns
def test_gradients_are_the_papers(bayer):
    windows, x0, y0 = windows_of(6)
    got = gradient_colours(windows, x0, y0, BAYER_PHASE[bayer])
    assert got.dtype == np.int64 and got.shape == (2, 2, 3, len(windows))
    for n, window in enumerate(windows):
        for j in range(2):
            for i in range(2):
                # The corners are the samples in rows and columns 2 and 3; y0 and x0 are of (2, 2).
                assert got[j, i, :, n].tolist() == malvar(window, bayer, 2 + j, 2 + i,
                                                          y0[n] - 2, x0[n] - 2)


def test_corners_are_decoded_as_the_geometry_says():
    windows, x0, y0 = windows_of(6)
    for interpolation, decode in ((GRADIENT, gradient_colours), (DIRECTIONAL, directional_colours)):
        geometry = Geometry(8, 8, 8, 8, bayer="GBRG", interpolation=interpolation)
        np.testing.assert_array_equal(corner_colours(windows, x0, y0, geometry),
                                      decode(windows, x0, y0, (0, 1)))
        grey = corner_colours(windows, x0, y0, Geometry(8, 8, 8, 8, bayer=MONO,
                                                        interpolation=interpolation))
        assert grey.shape == (2, 2, 3, len(windows))
        for n, window in enumerate(windows.tolist()):
            for j in range(2):
                for i in range(2):
                    assert grey[j, i, :, n].tolist() == 3 * [16 * window[2 + j][2 + i]]
    three, x0, y0 = windows_of(3)
    np.testing.assert_array_equal(corner_colours(three, x0, y0, Geometry(8, 8, 8, 8)),
                                  bayer_quads(three, x0, y0, (0, 0)))


def mirrored(k, size):
    """Sample of a line of ``size`` that stands for index k."""
    return -k if k < 0 else 2 * (size - 1) - k if k >= size else k


@pytest.mark.parametrize("interpolation,margin,side", [(FAST, 0, 3), (GRADIENT, 2, 6)])
def test_windows_are_those_of_the_mirrored_frame(interpolation, margin, side):
    raw = RNG.integers(0, 256, (7, 9), np.uint8)
    got = raw_windows(raw, interpolation)
    core = side - 2 * margin
    assert got.shape == (7 - core + 1, 9 - core + 1, side, side)
    for y0 in range(got.shape[0]):
        for x0 in range(got.shape[1]):
            assert got[y0, x0].tolist() == [
                [int(raw[mirrored(y0 + j - margin, 7), mirrored(x0 + i - margin, 9)])
                 for i in range(side)] for j in range(side)]


@pytest.mark.parametrize("interpolation,core,offset", [
    (FAST, 3, Fraction(1, 2)), (GRADIENT, 2, 0), (DIRECTIONAL, 2, 0)])
def test_the_address_of_a_window(interpolation, core, offset):
    geometry, q = Geometry(8, 8, 11, 9, interpolation=interpolation), Q(14, 4)
    raw_x, raw_y = (a.ravel() for a in np.meshgrid(np.arange(-40, 16 * 13), [-17, 24, 40, 143]))
    *got, inside = window_address(raw_x, raw_y, geometry, q)
    assert inside.dtype == bool
    for n in range(len(raw_x)):
        want, seen = [], True
        for raw, size in ((raw_x[n], 11), (raw_y[n], 9)):
            at = Fraction(int(raw), 16) - offset
            last = size - core
            seen &= -1 <= floor(at) <= last + 1
            # A source out by one row or column is moved to the edge, or just before it.
            at = max(at, Fraction(0))
            at = min(at, last + Fraction(15, 16))
            want.append((floor(at), 16 * (at - floor(at))))
        (x0, fx), (y0, fy) = want
        assert [int(part[n]) for part in got] == ([x0, y0, fx, fy] if seen else [0, 0, 0, 0])
        assert inside[n] == seen


def test_a_fetch_for_every_change_of_the_window():
    x0 = np.array([[3, 3, 4, 4], [4, 9, 9, 9]])
    y0 = np.array([[1, 1, 1, 2], [2, 7, 2, 2]])
    used = np.array([[1, 1, 1, 1], [1, 0, 1, 1]], bool)
    # (3, 1), (4, 1), (4, 2), (9, 2): the pixel without a source reads nothing.
    assert fetches(x0, y0, used) == 4 and type(fetches(x0, y0, used)) is int
    used[1, 1] = True
    assert fetches(x0, y0, used) == 5
    assert fetches(x0, y0, used & (x0 == 4) & (y0 == 1)) == 1
    assert fetches(x0, y0, np.zeros((2, 4), bool)) == 0


def blended(corners, fx, fy, row_bits, unit_bits, crest):
    """A colour between four corners, exact but for what a row cuts off; equations (30)-(32)."""
    rows = []
    for left, right in corners:
        colour = ((1 - fx) * left + fx * right) / (1 << unit_bits)
        rows.append(colour if row_bits is None else Fraction(floor(colour * (1 << row_bits)),
                                                             1 << row_bits))
    total = (1 - fy) * rows[0] + fy * rows[1]
    if crest:
        total += Fraction(crest, 1 << row_bits)
    return min(max(floor(total + Fraction(1, 2)), 0), 255)


@pytest.mark.parametrize("f_bits", [5, 10])
@pytest.mark.parametrize("interpolation,row_bits,unit_bits,crest", [
    (FAST, None, 1, 0), (GRADIENT, 6, 4, 0), (DIRECTIONAL, 6, 4, 1)])
def test_blending_is_exact_but_for_what_a_row_cuts_off(interpolation, row_bits, unit_bits, crest,
                                                       f_bits):
    count = 160
    fx, fy = RNG.integers(0, 1 << f_bits, (2, count))
    quads = RNG.integers(-40 << unit_bits, 290 << unit_bits, (2, 2, 3, count))
    crests = crest * RNG.integers(-4000, 4000, count)
    got = bilinear(quads, fx, fy, f_bits, interpolation, crests)
    assert got.dtype == np.uint8 and got.shape == (count, 3) and {0, 255} < set(got.ravel())
    for n in range(count):
        for colour in range(3):
            assert got[n, colour] == blended(
                quads[:, :, colour, n].tolist(), *(Fraction(int(f[n]), 1 << f_bits)
                                                   for f in (fx, fy)),
                row_bits, unit_bits, int(crests[n]))
    if not crest:
        np.testing.assert_array_equal(bilinear(quads, fx, fy, f_bits, interpolation), got)
    if interpolation == FAST:
        np.testing.assert_array_equal(bilinear(quads, fx, fy, f_bits), got)
    rows = [part.reshape(*part.shape[:-1], 8, 20) for part in (quads, fx, fy, crests)]
    np.testing.assert_array_equal(bilinear(*rows[:3], f_bits, interpolation, rows[3]),
                                  got.reshape(8, 20, 3))
