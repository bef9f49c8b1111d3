"""Frames in memory: where they lie, and how their pixels are stored."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.fetch.cache_options import TILE_WIDTH

__all__ = ["ADDRESS_BITS", "FramePlaces", "PIXEL_BYTES", "SOURCE_BEYOND", "frame_bytes",
           "raw_image", "source_bytes", "stored_picture", "target_bytes"]

ADDRESS_BITS = 32
SOURCE_BEYOND = 12      # bytes behind a raw frame's last row that may be read, at most
PIXEL_BYTES = 4         # blue, green, red, zero: the usual XRGB8888 in little-endian memory
_ALIGN = 4096           # bytes; the corrected frame begins at a multiple of this


@dataclass(frozen=True)
class FramePlaces:
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
        """Those of a corrector that no host has told otherwise, on a memory of ``data_width`` bits.

        The raw frame is at 0, its rows as close as words allow; the corrected frame is on the next
        multiple of 4096 bytes behind it.
        """
        word = data_width // 8
        pitch = -(-geometry.distorted_width // word) * word
        return cls(0, -(-pitch * geometry.distorted_height // _ALIGN) * _ALIGN, pitch)


def frame_bytes(geometry):
    """Bytes of a corrected frame in memory."""
    return geometry.corrected_width * geometry.corrected_height * PIXEL_BYTES


def source_bytes(geometry, pitch):
    """Bytes that are read of a raw frame whose rows are ``pitch`` bytes apart.

    Samples are read 16 at a time, so that the last row may be followed by up to
    ``SOURCE_BEYOND`` bytes more; by none if the pitch is a multiple of 16.
    """
    last_row = -(-geometry.distorted_width // TILE_WIDTH) * TILE_WIDTH
    return (geometry.distorted_height - 1) * pitch + max(pitch, last_row)


def target_bytes(geometry, data_width):
    """Bytes that a corrected frame takes in memory, in whole words of ``data_width`` bits."""
    word = data_width // 8
    return -(-frame_bytes(geometry) // word) * word


def raw_image(raw, pitch):
    """Bytes of the ``raw`` frame, uint8 (height, width), in memory, rows ``pitch`` bytes apart."""
    return np.pad(raw, ((0, 0), (0, pitch - raw.shape[1]))).tobytes()


def stored_picture(stored):
    """Red, green, blue of pixels as a corrector stores them: uint8 (..., 4) to (..., 3)."""
    return stored[..., 2::-1]
