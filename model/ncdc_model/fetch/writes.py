"""What a frame writes to memory: accesses of the corrected picture, in the order of the scan."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_model.interface.frames import output_format

__all__ = ["FrameWrites", "frame_writes"]


@dataclass(frozen=True)
class FrameWrites:
    """Accesses to blocks of memory, lists of the same length, in order.

    Parameters
    ----------
    address : list of int
        First byte.
    words : list of int
        Words of the port that the access is put together from.
    last : list of int
        Number, in the order of the scan, of the last pixel of its burst: then the burst begins.
    held : list of int
        Number of the first pixel that the full writer holds up until the access is on the bus.
    others : callable, optional
        ``others()`` gives what somebody else writes through the same port: (edge, address, words)
        of each access, the edge at which its last word could be accepted, ascending.
    """
    address: list
    words: list
    last: list
    held: list
    others: object = None

    def by_lookup(self, pixel):
        """The same with the numbers of look-ups, whose first pixels are ``pixel``."""
        last, held = (np.searchsorted(pixel, numbers, "right") - 1
                      for numbers in (self.last, self.held))
        return replace(self, last=last.tolist(), held=held.tolist())


def frame_writes(geometry, hardware, block, base, timing):
    """:class:`FrameWrites` of a frame.

    Parameters
    ----------
    geometry : Geometry
    hardware : Hardware
        Data width, strips, and format of the pixels.
    block : int
        Bytes of the aligned blocks that an access does not leave.
    base : int
        Byte address of the frame.
    timing : CorrectorTiming
        Words of a burst, and what the queues hold.
    """
    word, strip, burst = hardware.data_width // 8, hardware.strip, timing.write_burst
    pixel_bytes = output_format(hardware.format).pixel_bytes
    width, height = geometry.corrected
    block = max(block, word)
    if strip:
        # A row of a strip ends its burst.
        left = np.repeat(np.arange(0, width, strip), height)
        row = np.tile(np.arange(height), -(-width // strip))
        pixels = np.minimum(strip, width - left)
        begin = base + pixel_bytes * (row * width + left)
    else:
        pixels, begin = np.array([width * height]), np.array([base])
    scanned = np.cumsum(pixels) - pixels
    end = begin + pixel_bytes * pixels
    count = (end - 1) // block - begin // block + 1
    which = np.repeat(np.arange(len(begin)), count)
    index = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    start = np.maximum((begin[which] // block + index) * block, begin[which])
    stop = np.minimum((start // block + 1) * block, end[which])
    words = (stop - 1) // word - start // word + 1
    begin_word = begin[which] // word
    burst_end = (((start // word - begin_word) // burst + 1) * burst + begin_word) * word
    last = (np.minimum(burst_end, end[which]) - 1 - begin[which]) // pixel_bytes
    first = (start - begin[which]) // pixel_bytes
    slack = timing.queued_words * word // pixel_bytes + timing.queued_pixels
    return FrameWrites(start.tolist(), words.tolist(), (scanned[which] + last).tolist(),
                       (scanned[which] + first + slack).tolist())
