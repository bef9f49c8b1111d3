"""Signed fixed-point formats and the one rounding operation of the golden model."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Q", "requantise"]


@dataclass(frozen=True)
class Q:
    """Signed two's complement format: value = raw / 2**f_bits.

    Parameters
    ----------
    i_bits : int
        Integer bits, the sign bit counted; may be zero or negative for fractions far below one.
    f_bits : int
        Fraction bits.
    """
    i_bits: int
    f_bits: int

    def __post_init__(self):
        if type(self.i_bits) is not int or type(self.f_bits) is not int:
            raise ValueError(f"{self} is no format, whole numbers of bits are needed")
        if self.width < 2:
            raise ValueError(f"{self} has {self.width} bits, at least 2 are needed")

    @property
    def width(self):
        """Bits in all."""
        return self.i_bits + self.f_bits

    @property
    def lo(self):
        """Smallest raw value."""
        return -(1 << (self.width - 1))

    @property
    def hi(self):
        """Largest raw value."""
        return (1 << (self.width - 1)) - 1

    def quantise(self, values):
        """Raw int64 of real ``values``, rounded to nearest (half up); does not saturate."""
        return np.floor(np.asarray(values, np.float64) * 2.0**self.f_bits + 0.5).astype(np.int64)

    def real(self, raw):
        """Real (float64) values of ``raw`` integers."""
        return np.asarray(raw, np.float64) / 2.0**self.f_bits

    def holds(self, raw):
        """Whether every one of the ``raw`` integers fits."""
        return bool(self.inside(np.asarray(raw)).all())

    def inside(self, raw):
        """Which of the ``raw`` integers fit, a bool array."""
        return (raw >= self.lo) & (raw <= self.hi)

    def __str__(self):
        return f"Q{self.i_bits}.{self.f_bits}"


def requantise(raw, shift, out):
    """Drop ``shift`` >= 1 fraction bits of ``raw``: add half, floor, saturate to format ``out``."""
    return np.clip((np.asarray(raw, np.int64) + (1 << (shift - 1))) >> shift, out.lo, out.hi)
