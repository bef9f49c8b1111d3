"""What a frame writes to memory: accesses of the corrected picture, in the order of the scan."""

from dataclasses import dataclass, replace

import numpy as np

__all__ = ["BURST", "FrameWrites", "PIXEL_BYTES", "frame_writes"]

BURST = 16              # words of a burst
PIXEL_BYTES = 4


@dataclass(frozen=True)
class FrameWrites:
    """Accesses to blocks of memory, lists of the same length, in order.

    Parameters
    ----------
    address : list of int
        First byte.
    words : list of int
        Words of the port that the access is put together from.
    first, last : list of int
        Number, in the order of the scan, of the first pixel of the access and of the last one of
        its burst: then the burst begins.
    """
    address: list
    words: list
    first: list
    last: list

    def by_lookup(self, pixel):
        """The same with the numbers of look-ups, whose first pixels are ``pixel``."""
        first, last = (np.searchsorted(pixel, numbers, "right") - 1
                       for numbers in (self.first, self.last))
        return replace(self, first=first.tolist(), last=last.tolist())


def frame_writes(width, height, strip, data_width, block, base):
    """:class:`FrameWrites` of a frame of four bytes per pixel.

    Parameters
    ----------
    width, height, strip : int
        Of the corrected picture; columns of a strip, 0 for raster.
    data_width : int
        Bits of a word.
    block : int
        Bytes of the aligned blocks that an access does not leave.
    base : int
        Byte address of the frame.
    """
    word = data_width // 8
    block = max(block, word)
    if strip:
        # A row of a strip ends its burst.
        left = np.repeat(np.arange(0, width, strip), height)
        row = np.tile(np.arange(height), -(-width // strip))
        pixels = np.minimum(strip, width - left)
        begin = base + PIXEL_BYTES * (row * width + left)
    else:
        pixels, begin = np.array([width * height]), np.array([base])
    scanned = np.cumsum(pixels) - pixels
    end = begin + PIXEL_BYTES * pixels
    count = (end - 1) // block - begin // block + 1
    which = np.repeat(np.arange(len(begin)), count)
    index = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    start = np.maximum((begin[which] // block + index) * block, begin[which])
    stop = np.minimum((start // block + 1) * block, end[which])
    words = (stop - 1) // word - start // word + 1
    begin_word = begin[which] // word
    burst_end = (((start // word - begin_word) // BURST + 1) * BURST + begin_word) * word
    last = (np.minimum(burst_end, end[which]) - 1 - begin[which]) // PIXEL_BYTES
    first = (start - begin[which]) // PIXEL_BYTES
    return FrameWrites(start.tolist(), words.tolist(), (scanned[which] + first).tolist(),
                       (scanned[which] + last).tolist())
