"""Frames in memory: where they lie, and how their pixels are stored."""

from dataclasses import dataclass

import numpy as np

from ncdc_spec import pixel_formats
from ncdc_spec.cache_options import TILE_WIDTH
from ncdc_spec.errors import InputError
from ncdc_spec.pixel_formats import PixelFormat

__all__ = ["ADDRESS_BITS", "BGR8", "BGRX8", "FrameAddresses", "MONO8", "OUTPUT_FORMATS",
           "OutputFormat", "SOURCE_BEYOND", "check_format", "frame_bytes", "output_format",
           "raw_image", "source_bytes", "stored_bytes", "stored_picture", "target_bytes"]

ADDRESS_BITS = 32
SOURCE_BEYOND = 12      # bytes after a raw frame's last row that may be read, at most
_ALIGN = 4096           # bytes; the corrected frame begins at a multiple of this


@dataclass(frozen=True)
class OutputFormat:
    """How the corrector stores a pixel in memory; pixels and rows follow without a gap.

    Parameters
    ----------
    name : str
        That of ``sent``, where the Pixel Format Naming Convention has one that fits.
    code : int
        In the register OUTPUT_FORMAT.
    sent : PixelFormat
        The same bytes on their way to a client, with their codes there.
    text : str
        The bytes of a pixel, in the order of their addresses.
    """
    name: str
    code: int
    sent: PixelFormat
    text: str

    @property
    def pixel_bytes(self):
        """Bytes of a pixel: 1, 3 or 4."""
        return self.sent.pixel_bytes


# The naming convention knows a fourth byte only as opacity, which the zero is not.
BGRX8 = OutputFormat("BGRX8", 0, pixel_formats.BGRA8, "blue, green, red, zero")
BGR8 = OutputFormat(pixel_formats.BGR8.name, 1, pixel_formats.BGR8, "blue, green, red")
MONO8 = OutputFormat(pixel_formats.MONO8.name, 2, pixel_formats.MONO8,
                     "green, which in a grey sensor's picture equals the others")

OUTPUT_FORMATS = {one.name: one for one in (BGRX8, BGR8, MONO8)}


def output_format(name):
    """The :class:`OutputFormat` of that name; raises :class:`InputError` if there is none."""
    if name not in OUTPUT_FORMATS:
        raise InputError(f"the format is {name!r}, one of {', '.join(OUTPUT_FORMATS)} is needed")
    return OUTPUT_FORMATS[name]


def check_format(form, geometry):
    """Raise :class:`InputError` if ``form`` would lose colours of a camera of ``geometry``."""
    if form == MONO8 and not geometry.mono:
        raise InputError(f"the format is {form.name}, which needs a grey sensor, the camera's "
                         f"colour filter is {geometry.bayer}")


@dataclass(frozen=True)
class FrameAddresses:
    """Where the raw and the corrected frame lie in memory.

    Parameters
    ----------
    source, target : int
        Byte address of the raw and of the corrected frame, multiples of the memory word.
    pitch : int
        Bytes from row to row of the raw frame, a multiple of the memory word.
    """
    source: int
    target: int
    pitch: int

    @classmethod
    def after_reset(cls, geometry, data_width):
        """Addresses of a corrector after reset, on a memory of ``data_width`` bits.

        The raw frame is at 0, its rows as close as words allow; the corrected frame is on the next
        multiple of 4096 bytes after it.
        """
        word = data_width // 8
        pitch = -(-geometry.distorted_width // word) * word
        return cls(0, -(-pitch * geometry.distorted_height // _ALIGN) * _ALIGN, pitch)


def frame_bytes(geometry, form=BGRX8):
    """Bytes of a corrected frame in memory, its pixels in the :class:`OutputFormat` ``form``."""
    return geometry.corrected_width * geometry.corrected_height * form.pixel_bytes


def source_bytes(geometry, pitch):
    """Bytes that are read of a raw frame whose rows are ``pitch`` bytes apart.

    Samples are read 16 at a time, so that the last row may be followed by up to
    ``SOURCE_BEYOND`` bytes more; by none if the pitch is a multiple of 16.
    """
    last_row = -(-geometry.distorted_width // TILE_WIDTH) * TILE_WIDTH
    return (geometry.distorted_height - 1) * pitch + max(pitch, last_row)


def target_bytes(geometry, data_width, form=BGRX8):
    """Bytes that a corrected frame in the :class:`OutputFormat` ``form`` takes in memory, in whole
    words of ``data_width`` bits."""
    word = data_width // 8
    return -(-frame_bytes(geometry, form) // word) * word


def raw_image(raw, pitch):
    """Bytes of the ``raw`` frame, uint8 (height, width), in memory, rows ``pitch`` bytes apart."""
    return np.pad(raw, ((0, 0), (0, pitch - raw.shape[1]))).tobytes()


def stored_bytes(picture, form=BGRX8):
    """What a corrector stores of ``picture``: RGB, uint8 (..., 3), to (..., bytes of a pixel)."""
    if form == MONO8:
        return picture[..., 1:2]
    return pixel_formats.packed(picture, form.sent)


def stored_picture(stored, form=BGRX8):
    """Red, green, blue of pixels as a corrector stores them: uint8 (..., bytes of a pixel) to
    (..., 3)."""
    if form == MONO8:
        return np.repeat(stored, 3, axis=-1)
    return pixel_formats.unpacked(stored, form.sent)
