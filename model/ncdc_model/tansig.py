"""Tan-sigmoid in integers: exponential by predicted hyperbolic rotations, division by LVC.

Equation (17) of the paper with gamma = 1, for a = ``|n|``::

    f(n) = sign(n) (1 - e) / (1 + e),   e = exp(-a)

The paper's structure (Fig. 9): the input is separated into sign, region and fraction; a table
holds the exponential of the region, rotations multiply it by that of the fraction (MMHBC), and
a linear vectoring CORDIC (LVC) divides. See docs/tansig.md for the derivation.
"""

from dataclasses import dataclass
from functools import cached_property

import mpmath
import numpy as np

from ncdc_model.fixed import Q

__all__ = ["TansigDesign", "tansig"]


@dataclass(frozen=True)
class TansigDesign:
    """Parameters of one tan-sigmoid, shared by the golden model and the gateware.

    Parameters
    ----------
    input : Q
        Format of n; gamma = 1.
    fraction_bits : int
        Accuracy P of the result in fraction bits; the result carries one more, see ``output``.
    width : int
        Fraction bits W of the exponential and of the quotient's remainder.
    region_bits : int
        Fraction bits t of the input that address the region table, beside all integer bits.

    Raises
    ------
    ValueError
        If no fraction bit is left to rotate by, or the first rotation's shift is not below W.
    """
    input: Q = Q(5, 19)
    fraction_bits: int = 20
    width: int = 25
    region_bits: int = 5

    def __post_init__(self):
        if not 0 < self.region_bits < self.input.f_bits:
            raise ValueError(f"region_bits is {self.region_bits}, the limits are 1 and "
                             f"{self.input.f_bits - 1}")
        if self.shifts[-1] > self.width:
            raise ValueError(f"the last rotation shifts by {self.shifts[-1]}, "
                             f"width {self.width} is the limit")

    @property
    def output(self):
        """Format of the result: ``fraction_bits`` + 1 fraction bits, the last one constant."""
        return Q(1, self.fraction_bits + 1)

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

    @cached_property
    def table(self):
        """Exponential of each region, raw with W fraction bits, as a tuple of integers.

        Entry A is exp(-(A 2**-t + c)) / prod(sqrt(1 - 4**-s)): c is the offset that recoding the
        fine bits from 0/1 to -1/+1 leaves, and the product is the rotations' scale factor, (28).
        """
        with mpmath.workdps(40):
            offset = mpmath.fsum(mpmath.mpf(2)**-s for s in self.shifts)
            scale = mpmath.fprod(mpmath.sqrt(1 - mpmath.mpf(4)**-s) for s in self.shifts)
            regions = range(1 << (self.input.i_bits - 1 + self.region_bits))
            return tuple(int(mpmath.nint(mpmath.ldexp(
                mpmath.exp(-mpmath.ldexp(A, -self.region_bits) - offset) / scale, self.width)))
                for A in regions)


_CHUNK = 1 << 15  # values at a time: the working set stays in the cache


def tansig(n, design=TansigDesign()):
    """Raw f(n) in ``design.output`` of raw ``n`` in ``design.input``, any shape.

    The result is odd (its last bit is one, an error of at most half a unit of ``fraction_bits``
    in place of rounding) except f(0) = 0; f(-n) = -f(n) bit for bit; the most negative n, which
    has no positive twin, gives the value of the one above it.
    """
    n = np.asarray(n, np.int64)
    result = np.empty(n.size, np.int64)
    flat = n.ravel()
    for start in range(0, n.size, _CHUNK):
        part = flat[start:start + _CHUNK]
        magnitude = np.minimum(np.abs(part), design.input.hi)
        odd = _quotient(_exponential(magnitude, design), design)
        result[start:start + _CHUNK] = np.sign(part) * odd
    return result.reshape(n.shape)


def _round_shift(value, shift):
    """``value`` >> ``shift``, the last bit shifted out added."""
    return (value + (1 << (shift - 1))) >> shift


def _exponential(a, design):
    """exp(-a) with W fraction bits: region table, then one rotation per fine bit.

    x = cosh and y = sinh always enter as x + y (23), and the rotation (24) acts on the sum u as
    u <- u - d (u >> s): one channel. No z channel either: the fine bits are the directions.
    """
    u = np.array(design.table)[a >> design.fine_bits]
    for k, shift in enumerate(design.shifts):
        step = _round_shift(u, shift)
        u += np.where((a >> (design.fine_bits - 1 - k)) & 1, -step, step)
    return u


def _quotient(u, design):
    """(1 - u) / (1 + u) with digits +-2**-i: raw, odd, ``fraction_bits`` + 1 fraction bits."""
    one = 1 << design.width
    remainder, divisor = one - u, one + u
    quotient = np.zeros_like(u)
    for i in range(1, design.digits + 1):
        plus = (remainder >= 0) | (i == 1)
        step = _round_shift(divisor, i)
        remainder += np.where(plus, -step, step)
        quotient += np.where(plus, 1, -1) << (design.digits - i)
    return quotient
