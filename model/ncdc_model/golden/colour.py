"""White balance and tone of corrected pixels, and the sums for their estimation."""

import math
from dataclasses import dataclass

import numpy as np

from ncdc_model.golden.tone import toned
from ncdc_spec.colour import COLOURS
from ncdc_spec.errors import InputError
from ncdc_spec.white_balance import GAIN_F_BITS, LARGEST_GAIN, UNITY

__all__ = ["ColourSums", "GREY_WORLD", "coloured", "gains_of"]

GREY_WORLD = "grey-world"


@dataclass(frozen=True)
class ColourSums:
    """Sums of the colours of the pixels with a source in a frame, before gain and tone.

    They are at most 4096 x 4096 x 255 and fit in 32 bits.
    """
    red: int
    green: int
    blue: int
    pixels: int

    @classmethod
    def of(cls, corrected):
        """Sums of the frame ``corrected``, a :class:`~ncdc_model.golden.corrector.Corrected`."""
        seen = corrected.picture[~corrected.blank]
        return cls(*seen.sum(axis=0, dtype=np.int64).tolist(), len(seen))

    @property
    def colours(self):
        """Sums of red, green and blue."""
        return self.red, self.green, self.blue

    @property
    def registers(self):
        """Values of the read-only registers, by name."""
        return {"RED_SUM": self.red, "GREEN_SUM": self.green, "BLUE_SUM": self.blue,
                "VALID_PIXELS": self.pixels}


def coloured(corrected, colour):
    """The picture of a :class:`ncdc_model.golden.corrector.Corrected` frame after ``colour``.

    Each colour c of a pixel with a source is, in integers::

        v = min(255, floor((gain_c in + 128) / 256))
        out = toned(v)

    Blank pixels keep the fill. Returns an array of uint8 of the shape (height, width, 3).
    """
    products = np.arange(256)[:, None] * np.array(colour.gains, np.int64)
    balanced = np.minimum(255, products + (1 << GAIN_F_BITS - 1) >> GAIN_F_BITS)
    out = toned(balanced, colour.tone)          # for every value (row) and colour (column)
    return np.where(corrected.blank[..., None], corrected.picture,
                    out[corrected.picture, np.arange(3)])


def gains_of(text, what="white balance"):
    """Gains in 256ths of the three decimal numbers in ``text``, "R,G,B", each rounded to nearest.

    ``what`` names them in messages.

    Raises
    ------
    InputError
        If there are not three, or one is outside the limits.
    """
    parts = text.split(",")
    if len(parts) != len(COLOURS):
        raise InputError(f"the {what} is {text!r}, three gains R,G,B or {GREY_WORLD} is "
                         f"needed")
    return tuple(_gain(name, part) for name, part in zip(COLOURS, parts))


def _gain(name, text):
    """The gain ``text`` of the colour ``name`` in 256ths, at least 1."""
    try:
        gain = float(text)
    except ValueError:
        raise InputError(f"the gain of {name} is {text!r}, a number is needed") from None
    if not 1 <= gain * UNITY <= LARGEST_GAIN:      # "nan" fails too
        raise InputError(f"the gain of {name} is {text.strip()}, the limits are "
                         f"{1 / UNITY} and {LARGEST_GAIN / UNITY}")
    return math.floor(gain * UNITY + 0.5)
