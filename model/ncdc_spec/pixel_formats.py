"""Formats of a picture on its way to a client, each with its number in either protocol."""

from dataclasses import dataclass

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYER_PHASE

__all__ = ["BGR8", "BGRA8", "MONO8", "PIXEL_FORMATS", "PixelFormat", "bayer_format",
           "format_of_mraw", "format_of_name", "format_of_pfnc", "packed", "raw_format", "unpacked"]


@dataclass(frozen=True)
class PixelFormat:
    """How the pixels of a picture are stored, row by row without gaps.

    Parameters
    ----------
    name : str
        As the Pixel Format Naming Convention has it.
    pfnc : int
        Its 32-bit code there: GVSP's pixel format.
    mraw : int
        The "formation" byte of Table II.
    pixel_bytes : int
    bayer : str
        The colour filter's pattern if the picture is a raw frame, else empty.
    text : str
    """
    name: str
    pfnc: int
    mraw: int
    pixel_bytes: int
    bayer: str
    text: str

    @property
    def raw(self):
        """Whether pixels are samples of the sensor, not corrected colours."""
        return bool(self.bayer)


def _bayer(name, pfnc, pattern):
    column, row = BAYER_PHASE[pattern]
    return PixelFormat(name, pfnc, column | row << 1, 1, pattern,
                       f"raw frame, colour filter {pattern}")


BGR8 = PixelFormat("BGR8", 0x02180015, 0x10, 3, "", "corrected: blue, green, red")
BGRA8 = PixelFormat("BGRa8", 0x02200017, 0x11, 4, "",
                    "corrected: blue, green, red, zero, as the corrector stores them")
MONO8 = PixelFormat("Mono8", 0x01080001, 0x12, 1, "",
                    "corrected: brightness, (red + 2 green + blue + 2) / 4 rounded down")

PIXEL_FORMATS = (
    _bayer("BayerRG8", 0x01080009, "RGGB"), _bayer("BayerGR8", 0x01080008, "GRBG"),
    _bayer("BayerGB8", 0x0108000A, "GBRG"), _bayer("BayerBG8", 0x0108000B, "BGGR"),
    BGR8, BGRA8, MONO8)


def _found(key, value, text):
    for pixel_format in PIXEL_FORMATS:
        if getattr(pixel_format, key) == value:
            return pixel_format
    known = ", ".join(pixel_format.name for pixel_format in PIXEL_FORMATS)
    raise InputError(f"the pixel format {text} is none of {known}")


def format_of_name(name):
    """The :class:`PixelFormat` of that name; raises :class:`InputError` if there is none."""
    return _found("name", name, repr(name))


def format_of_pfnc(pfnc):
    """The :class:`PixelFormat` of a code of GVSP; raises :class:`InputError`."""
    return _found("pfnc", pfnc, f"0x{pfnc:08X}")


def format_of_mraw(mraw):
    """The :class:`PixelFormat` of a formation byte of Table II; raises :class:`InputError`."""
    return _found("mraw", mraw, f"0x{mraw:02X} of Table II")


def bayer_format(pattern):
    """The :class:`PixelFormat` of raw frames with a colour filter of that ``pattern``."""
    return _found("bayer", pattern, f"of the pattern {pattern}")


def raw_format(geometry):
    """The :class:`PixelFormat` of raw frames of a ``geometry``, whose sensor may be grey."""
    return MONO8 if geometry.mono else bayer_format(geometry.bayer)


def packed(picture, pixel_format):
    """The (height, width, ...) uint8 array that goes out: ``picture``, RGB or raw, as stored."""
    if pixel_format.raw:
        return np.ascontiguousarray(picture)
    if pixel_format in (BGR8, BGRA8):
        stored = np.zeros((*picture.shape[:-1], pixel_format.pixel_bytes), np.uint8)
        for colour in range(3):         # a colour at a time is four times as fast as all
            stored[..., colour] = picture[..., 2 - colour]
        return stored
    red, green, blue = np.moveaxis(picture.astype(np.uint16), -1, 0)
    return ((red + 2 * green + blue + 2) >> 2).astype(np.uint8)


def unpacked(stored, pixel_format):
    """A picture to look at or compute with, of :func:`packed` ``stored``.

    RGB (height, width, 3) of the colour formats; (height, width) of raw frames and brightness.
    """
    return stored[..., 2::-1] if pixel_format.pixel_bytes >= 3 else stored
