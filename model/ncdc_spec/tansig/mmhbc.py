"""The paper's tan-sigmoid: predicted hyperbolic rotations (MMHBC), then division by LVC.

The structure is that of the paper's Fig. 9. The input is split into sign, region and fraction. A
table has the exponential of the region, rotations multiply it by that of the fraction (MMHBC), and
a linear vectoring CORDIC (LVC) divides.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import mpmath
import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.tansig.design import Design
from ncdc_spec.tansig.lvc import quotient, round_shift
from ncdc_spec.tansig.mmhbc_bound import error_bound

__all__ = ["TansigDesign"]

# Entries that differ from the rounded exponential, by input, P, W, t: with them no output
# decreases. Derived by tuning.monotonic_tuning; the error bound is that of the tuned table.
_TUNED = {
    (Q(5, 19), 16, 21, 4): {12: 1, 21: 1, 23: -1, 27: -1, 31: -1, 34: -1, 47: -1, 67: -1, 73: -1,
                            84: 1},
    (Q(5, 19), 18, 23, 4): {16: 1, 22: 1, 33: -1, 55: -1, 56: -1, 78: 1},
    (Q(5, 19), 20, 25, 5): {196: -1},
    (Q(5, 19), 22, 27, 6): {314: -1, 317: -1, 336: -1, 348: -1, 508: 1},     # not faithful
    (Q(5, 19), 22, 28, 6): {478: 1, 492: 1, 551: 1},
}


@dataclass(frozen=True)
class TansigDesign(Design):
    """The ``mmhbc`` variant; parameters in addition to those of :class:`Design`:

    Parameters
    ----------
    width : int
        Fraction bits W of the exponential and of the quotient's remainder.
    region_bits : int
        Fraction bits t of the input that address the region table, in addition to the integer bits.
    """
    width: int = 25
    region_bits: int = 5
    variant: ClassVar[str] = "mmhbc"
    # The smallest W, then the smallest t, that is faithful and monotonic.
    _DEFAULTS: ClassVar[dict] = {16: {"width": 21, "region_bits": 4},
                                 18: {"width": 23, "region_bits": 4},
                                 20: {"width": 25, "region_bits": 5},
                                 22: {"width": 28, "region_bits": 6}}
    multipliers: ClassVar[int] = 0

    def _check(self):
        if not 0 < self.region_bits < self.input.f_bits:
            raise InputError(f"region_bits is {self.region_bits}, the limits are 1 and "
                             f"{self.input.f_bits - 1}")
        if self.shifts[-1] > self.width:
            raise InputError(f"the last rotation shifts by {self.shifts[-1]}, "
                             f"width {self.width} is the limit")

    @property
    def fine_bits(self):
        """Fraction bits of the input below the region: one rotation each."""
        return self.input.f_bits - self.region_bits

    @property
    def shifts(self):
        """Shift of each rotation, the input's highest fine bit first.

        A fine bit of weight 2**-m stands for the two directions of a rotation by 2**-(m + 1).
        """
        return tuple(range(self.region_bits + 2, self.input.f_bits + 2))

    @property
    def digits(self):
        """Quotient digits of the LVC; the first is always +1/2."""
        return self.fraction_bits + 1

    @property
    def adders(self):
        """Magnitude, rotations, 1 - e, digits; the last digit and 1 + e need none."""
        return 1 + len(self.shifts) + 1 + self.digits - 1

    @property
    def table_bits(self):
        """Bits of the region table."""
        return len(self.table) * self.width

    @property
    def stages(self):
        """Rotations, numerator and denominator, digits."""
        return len(self.shifts) + 1 + self.digits

    @cached_property
    def rounded_table(self):
        """Exponential of each region, rounded to W fraction bits, as a tuple of integers.

        Entry A is exp(-(A 2**-t + c)) / prod(sqrt(1 - 4**-s)): c is the offset from recoding the
        fine bits from 0/1 to -1/+1, and the product is the rotations' scale factor, (28).
        """
        with mpmath.workdps(40):
            offset = mpmath.fsum(mpmath.mpf(2)**-s for s in self.shifts)
            scale = mpmath.fprod(mpmath.sqrt(1 - mpmath.mpf(4)**-s) for s in self.shifts)
            regions = range(1 << (self.input.i_bits - 1 + self.region_bits))
            return tuple(int(mpmath.nint(mpmath.ldexp(
                mpmath.exp(-mpmath.ldexp(A, -self.region_bits) - offset) / scale, self.width)))
                for A in regions)

    @cached_property
    def table(self):
        """:attr:`rounded_table` with the few changes that make the result monotonic."""
        key = self.input, self.fraction_bits, self.width, self.region_bits
        changes = _TUNED.get(key, {})
        return tuple(entry + changes.get(A, 0) for A, entry in enumerate(self.rounded_table))

    @property
    def entries(self):
        """Number of table entries, in the order of the input."""
        return len(self.rounded_table)

    def changed_entry(self, entry, change):
        """Raw results of all inputs of one region if its rounded entry is changed, f(0) = 0."""
        fine = np.arange(1 << self.fine_bits)
        u = self._rotate(np.full(len(fine), self.rounded_table[entry] + change), fine)
        q = quotient(u, self.width, self.digits)
        return q if entry else np.append(0, q[1:])

    def exponential(self, a):
        """exp(-a) with W fraction bits: region table, then one rotation per fine bit.

        x = cosh and y = sinh always enter as x + y (23). The rotation (24) of the sum u is
        u <- u - d (u >> s): one channel. There is no z channel, since the fine bits are the
        directions.
        """
        return self._rotate(np.array(self.table)[a >> self.fine_bits], a)

    def _rotate(self, u, a):
        for k, shift in enumerate(self.shifts):
            step = round_shift(u, shift)
            u = u + np.where((a >> (self.fine_bits - 1 - k)) & 1, -step, step)
        return u

    def magnitude(self, a):
        """See :class:`Design`."""
        return quotient(self.exponential(a), self.width, self.digits)

    def _bound(self):
        return error_bound(self)
