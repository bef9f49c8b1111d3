"""The tan-sigmoid as a table of quadratics: small if multipliers are available.

The magnitude is divided into segments, narrow where f curves and wide at the far end. A table has a
quadratic for each, which takes two multiplications and two additions.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import mpmath
import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.tansig.design import Design

__all__ = ["TableDesign"]

# Extrema of the Chebyshev cubic on [0, 1], and the same with its first zero moved to 0.
_NODES = tuple(mpmath.mpf(k) / 4 for k in (0, 1, 3, 4))
_NODES_FROM_ZERO = tuple((2 * mpmath.mpf(k) + mpmath.sqrt(3)) / (2 + mpmath.sqrt(3))
                         for k in (-.5, .5, 1))
_SAMPLES = 256             # per segment, of the error
# Changes of values, by input, P and parameters: with them no output decreases. Derived by
# tuning.monotonic_tuning; the error bound is that of the tuned table.
_TUNED = {
    (Q(5, 19), 16, (3, 2, 1), 26, 22): {2: -6, 3: -5, 39: -1, 41: -1, 44: 1, 45: -1, 46: 1, 48: 12,
                                        49: 8, 50: 5, 51: -1, 52: -1},
    (Q(5, 19), 18, (4, 3, 1), 29, 24): {96: 2, 97: 4, 98: 6, 99: 4, 100: -1},
    (Q(5, 19), 20, (4, 3, 1), 31, 26): {99: -2, 100: -4, 101: 2, 103: -1, 104: -1},
    (Q(5, 19), 22, (5, 4, 2), 32, 28): {200: -2, 201: -2, 202: 3, 203: -1, 204: 4, 205: -4,
                                        207: -1, 212: -1, 213: 1, 215: -1},
}


@dataclass(frozen=True)
class TableDesign(Design):
    """The ``table`` variant; parameters in addition to those of :class:`Design`:

    Parameters
    ----------
    segment_bits : (int, int, int)
        Fraction bits of the input that address the table, for magnitudes in the lowest quarter of
        the range, in the second quarter, and in the upper half.
    slope_bits : int
        Fraction bits F of the slope and curvature, per width of a segment.
    offset_bits : int
        Fraction bits of the value at a segment's start.
    """
    segment_bits: tuple = (4, 3, 1)
    slope_bits: int = 31
    offset_bits: int = 26
    variant: ClassVar[str] = "table"
    _DEFAULTS: ClassVar[dict] = {
        16: {"segment_bits": (3, 2, 1), "slope_bits": 26, "offset_bits": 22},
        18: {"segment_bits": (4, 3, 1), "slope_bits": 29, "offset_bits": 24},
        20: {"segment_bits": (4, 3, 1), "slope_bits": 31, "offset_bits": 26},
        22: {"segment_bits": (5, 4, 2), "slope_bits": 32, "offset_bits": 28},
    }
    multipliers: ClassVar[int] = 2
    adders: ClassVar[int] = 3      # magnitude, slope, value
    stages: ClassVar[int] = 5      # table, product, slope, product, value

    def _check(self):
        low, middle, high = self.segment_bits
        if not high < middle < low < self.input.f_bits or self.input.i_bits < 3:
            raise InputError(f"segment_bits are {self.segment_bits}, they must fall, below "
                             f"{self.input.f_bits}, for an input of 3 integer bits or more")
        if not self.fraction_bits < self.offset_bits <= self.slope_bits + self.position_bits:
            raise InputError(f"offset_bits is {self.offset_bits}, the limits are "
                             f"{self.fraction_bits + 1} and {self.slope_bits + self.position_bits}")

    @property
    def position_bits(self):
        """Bits of the position t in a segment; low ones are zero in narrow segments."""
        return self.input.f_bits - min(self.segment_bits)

    @property
    def ranges(self):
        """(first entry, first raw magnitude, raw segment width as a power of two) of each range."""
        quarter = 1 << (self.input.width - 3)
        low, middle, high = (self.input.f_bits - bits for bits in self.segment_bits)
        return ((0, 0, low), (quarter >> low, quarter, middle),
                ((quarter >> low) + (quarter >> middle), 2 * quarter, high))

    @property
    def segments(self):
        """(raw start, raw width) of every segment."""
        quarter = 1 << (self.input.width - 3)
        ends = (quarter, 2 * quarter, 4 * quarter)
        return [(start, 1 << log) for (_, first, log), end in zip(self.ranges, ends)
                for start in range(first, end, 1 << log)]

    @cached_property
    def fitted(self):
        """(value, slope, curvature) of each segment, non-negative raw integers.

        f is value + t (slope - t curvature) for t in [0, 1) over the segment. The quadratic has
        equal errors of alternating sign at the extrema of the Chebyshev cubic, which is one step of
        the Remez exchange; the first one passes through zero. Curvature, slope and value are
        rounded in this order, each compensating for the previous ones.
        """
        with mpmath.workdps(30):
            return tuple(self._fit(start, width) for start, width in self.segments)

    @cached_property
    def coefficients(self):
        """:attr:`fitted` with the few changes of values that make the result monotonic."""
        key = self.input, self.fraction_bits, self.segment_bits, self.slope_bits, self.offset_bits
        changes = _TUNED.get(key, {})
        return tuple((value + changes.get(k, 0), slope, curvature)
                     for k, (value, slope, curvature) in enumerate(self.fitted))

    def _fit(self, start, width):
        nodes = _NODES if start else _NODES_FROM_ZERO
        f = [mpmath.tanh(mpmath.ldexp(start + t * width, -self.input.f_bits - 1)) for t in nodes]
        rows = [[t, -t * t, (-1)**k, 1][:len(nodes)] for k, t in enumerate(nodes)]
        exact = mpmath.lu_solve(mpmath.matrix(rows), mpmath.matrix(f))
        curvature = _nearest(exact[1], self.slope_bits)
        # The slope compensates for the curvature's rounding at the segment's end.
        slope = _nearest(exact[0] - exact[1] + mpmath.ldexp(curvature, -self.slope_bits),
                         self.slope_bits)
        residue = [y - mpmath.ldexp(t * (slope - t * curvature), -self.slope_bits)
                   for t, y in zip(nodes, f)]
        value = _nearest((max(residue) + min(residue)) / 2, self.offset_bits) if start else 0
        return value, slope, curvature

    @property
    def coefficient_bits(self):
        """Width of value, slope and curvature."""
        return tuple(max(column).bit_length() for column in zip(*self.coefficients))

    @property
    def table_bits(self):
        """Bits of the table."""
        return len(self.coefficients) * sum(self.coefficient_bits)

    @property
    def entries(self):
        """Number of table entries, in the order of the input."""
        return len(self.segments)

    def changed_entry(self, entry, change):
        """Raw results of all inputs of one segment if its fitted value is changed, f(0) = 0."""
        value, slope, curvature = self.fitted[entry]
        start, width = self.segments[entry]
        _, t = self.locate(np.arange(start, start + width))
        q = 2 * self._floor(value + change, slope, curvature, t) + 1
        return q if entry else np.append(0, q[1:])

    def locate(self, a):
        """(segment, position) of raw magnitudes: entry number, t with ``position_bits`` bits."""
        segment, position = np.zeros_like(a), np.zeros_like(a)
        for entry, first, log in self.ranges:
            here = a >= first
            segment = np.where(here, entry + ((a - first) >> log), segment)
            inside = (a & ((1 << log) - 1)) << (self.position_bits - log)
            position = np.where(here, inside, position)
        return segment, position

    def magnitude(self, a):
        """See :class:`Design`."""
        segment, t = self.locate(a)
        value, slope, curvature = np.array(self.coefficients)[segment].T
        return 2 * self._floor(value, slope, curvature, t) + 1

    def _floor(self, value, slope, curvature, t):
        """value + t (slope - t curvature), floored to ``fraction_bits``."""
        steepness = slope - ((curvature * t) >> self.position_bits)
        below = self.slope_bits + self.position_bits
        total = (value << (below - self.offset_bits)) + t * steepness
        return np.minimum(total >> (below - self.fraction_bits), (1 << self.fraction_bits) - 1)

    def _bound(self):
        """Sum of half a unit of the last bit, the largest error, and the truncated product."""
        starts, widths = (np.array(column)[:, None] for column in zip(*self.segments))
        value, slope, curvature = (np.array(column)[:, None] for column in zip(*self.coefficients))
        t = np.arange(_SAMPLES + 1) / _SAMPLES
        h = self.input.real(widths)
        polynomial = (value * 2.0**-self.offset_bits
                      + t * (slope - t * curvature) * 2.0**-self.slope_bits)
        error = np.abs(polynomial - np.tanh(self.input.real(starts + t * widths) / 2))
        # |f'''| <= f' <= min(1/4, 2 exp(-a)) bounds the error's curvature between samples.
        between = np.minimum(.25, 2 * np.exp(-self.input.real(starts))) * h * (h / _SAMPLES)**2 / 8
        worst = float((error.max(1, keepdims=True) + between).max())
        return .5 + (worst + 2.0**-self.slope_bits) * 2.0**self.fraction_bits


def _nearest(value, bits):
    """Raw integer of ``value`` with ``bits`` fraction bits."""
    return int(mpmath.nint(mpmath.ldexp(value, bits)))
