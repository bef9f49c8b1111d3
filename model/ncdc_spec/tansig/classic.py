"""A conventional tan-sigmoid, for comparison: hyperbolic CORDIC with repeats, then LVC.

It follows Asari's neuron, [15] of the paper: exp(-a) = exp(-integer) exp(-fraction), equation (29).
A small table has the first factor, and (24)-(28) with x, y and z channels give the second; one
multiplication joins them.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import mpmath
import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.tansig.design import Design
from ncdc_spec.tansig.lvc import quotient, quotient_error, round_shift

__all__ = ["ClassicDesign"]

_REPEATED = (4, 13)        # repeated iterations: without them the rotation does not converge
_GROUPS = 1024             # groups of fractions with a bound each


@dataclass(frozen=True)
class ClassicDesign(Design):
    """The ``classic`` variant; parameters in addition to those of :class:`Design`:

    Parameters
    ----------
    width : int
        Fraction bits W of x, y, z, the tables and the quotient's remainder.
    last_shift : int
        Shift of the last iteration; the angle left over is below 2**-last_shift.
    """
    width: int = 25
    last_shift: int = 22
    variant: ClassVar[str] = "classic"
    # The smallest W, then the fewest iterations, that are faithful and monotonic.
    _DEFAULTS: ClassVar[dict] = {16: {"width": 22, "last_shift": 19},
                                 18: {"width": 23, "last_shift": 21},
                                 20: {"width": 25, "last_shift": 22},
                                 22: {"width": 27, "last_shift": 24}}
    multipliers: ClassVar[int] = 1

    def _check(self):
        if not max(self.input.f_bits, self.last_shift) <= self.width:
            raise InputError(f"width is {self.width}, the last shift {self.last_shift} and the "
                             f"input's {self.input.f_bits} fraction bits are the limits")

    @property
    def shifts(self):
        """Shift of each iteration: 1, 2, 3, 4, 4, 5, ... 13, 13, ..."""
        return tuple(k for k in range(1, self.last_shift + 1) for _ in range(1 + (k in _REPEATED)))

    @property
    def digits(self):
        """Quotient digits of the LVC; the first is always +1/2."""
        return self.fraction_bits + 1

    @property
    def adders(self):
        """Magnitude, x, y, z of each iteration, x + y, rounding, 1 - e, digits but the last.

        The first iteration's x and y are constants; the last needs no z.
        """
        return 1 + 3 * len(self.shifts) - 3 + 1 + 1 + 1 + self.digits - 1

    @property
    def table_bits(self):
        """Bits of the table of exp(-integer); exp(0) = 1 takes a bit more."""
        return len(self.table) * (self.width + 1)

    @property
    def stages(self):
        """Iterations, x + y, product, numerator and denominator, digits."""
        return len(self.shifts) + 2 + 1 + self.digits

    @cached_property
    def table(self):
        """exp(-integer) for each integer part, raw with W fraction bits."""
        with mpmath.workdps(40):
            return tuple(int(mpmath.nint(mpmath.ldexp(mpmath.exp(-i), self.width)))
                         for i in range(1 << (self.input.i_bits - 1)))

    @cached_property
    def angles(self):
        """atanh(2**-k) of each iteration (26), raw with W fraction bits."""
        with mpmath.workdps(40):
            return tuple(int(mpmath.nint(mpmath.ldexp(mpmath.atanh(mpmath.mpf(2)**-k), self.width)))
                         for k in self.shifts)

    @cached_property
    def start(self):
        """First x, raw with W fraction bits: 1 / K, which cancels the scale factor (28)."""
        with mpmath.workdps(40):
            scale = mpmath.fprod(mpmath.sqrt(1 - mpmath.mpf(4)**-k) for k in self.shifts)
            return int(mpmath.nint(mpmath.ldexp(1 / scale, self.width)))

    def fraction_exponential(self, fraction):
        """exp(-fraction) with W fraction bits of the raw ``fraction`` in [0, 1), as x + y.

        The angle z starts at -fraction, so that the first direction is always negative, also for
        zero.
        """
        z = -(np.asarray(fraction, np.int64) << (self.width - self.input.f_bits))
        x, y = np.full_like(z, self.start), np.zeros_like(z)
        for k, (shift, angle) in enumerate(zip(self.shifts, self.angles)):
            minus = (z < 0) | (k == 0)
            dx, dy = round_shift(y, shift), round_shift(x, shift)
            x = x + np.where(minus, -dx, dx)
            y = y + np.where(minus, -dy, dy)
            z = z + np.where(minus, angle, -angle)
        return x + y

    def product(self, integer, u):
        """exp(-integer) u, rounded to W fraction bits."""
        return round_shift(np.array(self.table)[integer] * u, self.width)

    def magnitude(self, a):
        """See :class:`Design`."""
        fraction = a & ((1 << self.input.f_bits) - 1)
        e = self.product(a >> self.input.f_bits, self.fraction_exponential(fraction))
        return quotient(e, self.width, self.digits)

    def _bound(self):
        """Error bound: the rotation's error is exact, from all fractions; product and quotient are
        bounded over each group of fractions and integer part."""
        w, unit = self.width, 2.0**(self.fraction_bits - self.width)
        count = 1 << self.input.f_bits
        fraction = np.arange(count).reshape(min(_GROUPS, count), -1)
        u = self.fraction_exponential(fraction)
        exact = np.exp(-self.input.real(fraction)) * 2.0**w
        error, lo, hi = np.abs(u - exact).max(1), u.min(1), u.max(1)
        smallest = exact.min(1)
        worst = 0.0
        for integer, entry in enumerate(self.table):
            power = float(mpmath.exp(-integer))
            wrong = error * power + hi * abs(entry / 2.0**w - power) + (.5 if integer else 0)
            e_lo, e_hi = (bound * power for bound in (lo, hi))
            slope = 2 / ((1 + smallest * power / 2.0**w) * (1 + e_lo / 2.0**w))
            ends = quotient_error(np.floor(e_lo - wrong), np.ceil(e_hi + wrong), w, self.digits)
            worst = max(worst, float((slope * wrong + ends).max()))
        return .5 + worst * unit
