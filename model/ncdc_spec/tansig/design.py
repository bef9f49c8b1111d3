"""Base of the tan-sigmoid variants: formats, signs, the check of the error bound."""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q

__all__ = ["Design", "tansig"]


@dataclass(frozen=True)
class Design(ABC):
    """Parameters of one tan-sigmoid, shared by the reference model and the gateware.

    Parameters
    ----------
    input : Q
        Format of n; gamma = 1.
    fraction_bits : int
        Accuracy P of the result in fraction bits; the result has one more, see ``output``.

    Attributes
    ----------
    variant : str
        Name of the variant, as on the command line.
    for_bits : classmethod
        ``for_bits(fraction_bits, input)``: the design with derived parameters for an accuracy.
    adders, multipliers, table_bits : int
        Cost in gateware: adders and subtractors on the data path, products, bits of ROM.
    stages : int
        Arithmetic steps in sequence.
    bound_ulp : float
        Upper bound of ``|f - result|`` in units of 2**-P, derived from the parameters.

    Raises
    ------
    InputError
        If the parameters are inconsistent, or the bound is 1 or more: not faithful.
    """
    input: Q = Q(5, 19)
    fraction_bits: int = 20
    variant: ClassVar[str]
    _DEFAULTS: ClassVar[dict]

    def __post_init__(self):
        self._check()
        if self.bound_ulp >= 1:
            raise InputError(f"the {self.variant} tan-sigmoid {self.parameters} is not faithful: "
                             f"its error bound is {self.bound_ulp:.3f} units of "
                             f"2**-{self.fraction_bits}, below 1 is needed")

    @classmethod
    def for_bits(cls, fraction_bits, input=Q(5, 19)):
        """The design for an accuracy of ``fraction_bits``.

        Raises
        ------
        InputError
            If no parameters are known for it, or they are not faithful with this input format.
        """
        if fraction_bits not in cls._DEFAULTS:
            raise InputError(f"the {cls.variant} tan-sigmoid has {fraction_bits} fraction bits, "
                             f"one of {', '.join(map(str, cls._DEFAULTS))} is needed")
        return cls(input, fraction_bits, **cls._DEFAULTS[fraction_bits])

    @property
    def parameters(self):
        """The parameters as text."""
        return ", ".join(f"{name} {value}" for name, value in vars(self).items()
                         if name in self.__dataclass_fields__)

    @property
    def output(self):
        """Format of the result: ``fraction_bits`` + 1 fraction bits, the last one constant."""
        return Q(1, self.fraction_bits + 1)

    @cached_property
    def largest(self):
        """Raw result of the largest magnitude, also used for the most negative n."""
        return int(self.magnitude(np.array([self.input.hi]))[0])

    @cached_property
    def bound_ulp(self):
        """See the class."""
        return self._bound()

    @abstractmethod
    def magnitude(self, a):
        """Raw f(a) in ``output``, odd integers, of raw magnitudes ``a`` (int64, 0..input.hi)."""

    @abstractmethod
    def _check(self):
        """Raise InputError if the parameters are inconsistent."""

    @abstractmethod
    def _bound(self):
        """The error bound in units of 2**-P."""


_CHUNK = 1 << 15  # values at a time: the working set stays in the cache


def tansig(n, design):
    """Raw f(n) in ``design.output`` of raw ``n`` in ``design.input``, any shape.

    The result is odd except f(0) = 0: its last bit is one, an error of at most half a unit of
    ``fraction_bits`` instead of rounding. f(-n) = -f(n) bit for bit. The most negative n, which has
    no positive counterpart, gives the value of n + 1.
    """
    n = np.asarray(n, np.int64)
    result = np.empty(n.size, np.int64)
    flat = n.ravel()
    for start in range(0, n.size, _CHUNK):
        part = flat[start:start + _CHUNK]
        magnitude = np.minimum(np.abs(part), design.input.hi)
        result[start:start + _CHUNK] = np.sign(part) * design.magnitude(magnitude)
    return result.reshape(n.shape)
