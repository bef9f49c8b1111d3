"""A picture as it came from a device."""

from dataclasses import dataclass

import numpy as np

from ncdc_host.client.errors import MalformedFrame
from ncdc_model.images import demosaic
from ncdc_spec.errors import InputError
from ncdc_spec.pixel_formats import PixelFormat, format_of_pfnc, unpacked

__all__ = ["Frame", "gvsp_format"]


def gvsp_format(code):
    """The :class:`PixelFormat` of GVSP's ``code``; :class:`MalformedFrame` if there is none."""
    try:
        return format_of_pfnc(code)
    except InputError as error:
        raise MalformedFrame(str(error)) from None


@dataclass(frozen=True)
class Frame:
    """A whole picture; an incomplete one never becomes a frame.

    Parameters
    ----------
    pixels : ndarray of uint8
        (height, width) of raw frames and Mono8, RGB (height, width, 3) of corrected colours;
        read-only.
    pixel_format : PixelFormat
        As sent.
    number : int
        Rises by one with every frame that the device sends; a gap is a frame that was lost. Over
        TCP it is the number of the frame since the device's reset.
    time_ns : int
        Device time of the capture, nanoseconds; over TCP in steps of a microsecond.
    """
    pixels: np.ndarray
    pixel_format: PixelFormat
    number: int
    time_ns: int

    @classmethod
    def of_bytes(cls, data, size, pixel_format, number, time_ns):
        """The frame of ``size`` (width, height) whose stored bytes are ``data``.

        Raises
        ------
        MalformedFrame
            If a side is 0, or the bytes are more or fewer than the size and the format say.
        """
        width, height = size
        needed = width * height * pixel_format.pixel_bytes
        if not needed:
            raise MalformedFrame(f"a picture came with {width}x{height} pixels")
        if len(data) != needed:
            raise MalformedFrame(f"a picture of {width}x{height} {pixel_format.name} came with "
                                 f"{len(data)} bytes, {needed} are needed")
        stored = np.frombuffer(data, np.uint8)
        if pixel_format.pixel_bytes > 1:
            stored = stored.reshape(height, width, pixel_format.pixel_bytes)
        else:
            stored = stored.reshape(height, width)
        pixels = unpacked(stored, pixel_format)
        pixels.flags.writeable = False
        return cls(pixels, pixel_format, number, time_ns)

    def picture(self):
        """RGB (height, width, 3) to look at: raw frames demosaiced, brightness as grey."""
        if self.pixel_format.raw:
            return demosaic(self.pixels, self.pixel_format.bayer)
        if self.pixels.ndim == 2:
            return np.repeat(self.pixels[..., None], 3, axis=2)
        return np.ascontiguousarray(self.pixels)
