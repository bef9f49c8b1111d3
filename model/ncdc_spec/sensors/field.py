"""Which part of a sensor the raw frames show: what is asked, and the reduction that it takes."""

import re
from dataclasses import dataclass

from ncdc_spec.errors import InputError

__all__ = ["FULL", "Field", "Way", "field_named", "ways_of"]

FULL = "full"
_SIZED = re.compile(r"(\d{1,5})x(\d{1,5})(?:\+(\d{1,5})\+(\d{1,5}))?")


@dataclass(frozen=True)
class Field:
    """A part of a sensor, in active pixels.

    Parameters
    ----------
    size : (int, int), optional
        Width and height; None: as much as fits.
    corner : (int, int), optional
        Left and top; None: around the sensor's middle.
    """
    size: tuple = None
    corner: tuple = None


@dataclass(frozen=True)
class Way:
    """How many active pixels become one of the raw frame, along either axis.

    Parameters
    ----------
    skip : int
        By the sensor.
    binning : int
        1 if the FPGA then makes one of two, else 0.
    """
    skip: int
    binning: int

    @property
    def reduction(self):
        """Active pixels for each one of the raw frame."""
        return self.skip << self.binning


def field_named(text):
    """The :class:`Field` that ``full``, ``WIDTHxHEIGHT`` or ``WIDTHxHEIGHT+LEFT+TOP`` asks for;
    raises :class:`InputError` for any other text."""
    if text == FULL:
        return Field()
    found = _SIZED.fullmatch(text)
    if not found:
        raise InputError(f"the field is {text!r}, {FULL}, WIDTHxHEIGHT or WIDTHxHEIGHT+LEFT+TOP, "
                         f"as in 2560x1920+16+12, is needed")
    numbers = [None if one is None else int(one) for one in found.groups()]
    return Field(tuple(numbers[:2]), tuple(numbers[2:]) if found[3] else None)


def ways_of(sensor, most):
    """The :class:`Way` to each reduction up to ``most``, as a dict.

    Of two ways it is the one in which the sensor skips more: fewer samples allow more frames per
    second. The FPGA bins the rest.
    """
    ways = {}
    for skip in sorted({1, *(skip for skip, _ in sensor.limits.reductions)}):
        for binning in (0, 1):
            way = Way(skip, binning)
            if way.reduction <= most:
                ways[way.reduction] = way       # a larger skip replaces a smaller one
    return dict(sorted(ways.items()))
