"""Accesses to the memory of a corrected picture: its own writes, and those of other hosts."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_spec.frames import output_format

__all__ = ["FrameWrites", "frame_writes"]


_PIECE = 1 << 16        # accesses at a time: bounds the memory of their arrays


@dataclass(frozen=True)
class FrameWrites:
    """Accesses to blocks of memory, in order.

    Parameters
    ----------
    count : int
        Number of accesses.
    parts : callable
        ``parts()`` gives them piece by piece, as four int arrays of the same length. First byte of
        the access; its words of the port; number, in the order of the scan, of the last pixel of
        its burst, which then begins; and number of the first pixel that the full writer stalls
        until the access is on the bus.
    others : callable, optional
        ``others()`` gives the writes of another host through the same port: (edge, address, words)
        of each access, the edge at which its last word could be accepted, ascending.
    reads : callable, optional
        ``reads()`` gives the reads of other hosts through ports of their own: (edge, address,
        words) of each access, the edge at which its command is accepted, ascending.
    """
    count: int = 0
    parts: object = tuple
    others: object = None
    reads: object = None

    def accesses(self):
        """(address, words, last pixel, stalled pixel) of each access, as :attr:`parts` has them."""
        for part in self.parts():
            yield from zip(*(array.tolist() for array in part))

    def by_lookup(self, pixel):
        """The same with numbers of look-ups instead of pixels; ``pixel``: their first pixels."""
        def parts():
            for address, words, *numbers in self.parts():
                yield address, words, *(
                    np.searchsorted(pixel, each.astype(pixel.dtype), "right") - 1
                    for each in numbers)
        return replace(self, parts=parts)


def frame_writes(geometry, hardware, block, base, timing):
    """:class:`FrameWrites` of a frame.

    Parameters
    ----------
    geometry : Geometry
    hardware : Hardware
        Data width, strips, and format of the pixels.
    block : int
        Bytes of the aligned blocks; no access crosses their borders.
    base : int
        Byte address of the frame.
    timing : CorrectorTiming
        Words of a burst, and capacity of the queues.
    """
    word, strip, burst = hardware.data_width // 8, hardware.strip, timing.write_burst
    pixel_bytes = output_format(hardware.format).pixel_bytes
    width, height = geometry.corrected
    block = max(block, word)
    if strip:
        # The end of a row of a strip ends the burst.
        left = np.repeat(np.arange(0, width, strip), height)
        row = np.tile(np.arange(height), -(-width // strip))
        pixels = np.minimum(strip, width - left)
        begin = base + pixel_bytes * (row * width + left)
    else:
        pixels, begin = np.array([width * height]), np.array([base])
    scanned = np.cumsum(pixels) - pixels
    end = begin + pixel_bytes * pixels
    until = np.cumsum((end - 1) // block - begin // block + 1)
    slack = timing.queued_words * word // pixel_bytes + timing.queued_pixels

    def part(number):
        which = np.searchsorted(until, number, "right")
        from_byte, to_byte = begin[which], end[which]
        index = number - np.append(0, until)[which]
        start = np.maximum((from_byte // block + index) * block, from_byte)
        stop = np.minimum((start // block + 1) * block, to_byte)
        words = (stop - 1) // word - start // word + 1
        begin_word = from_byte // word
        burst_end = (((start // word - begin_word) // burst + 1) * burst + begin_word) * word
        last = (np.minimum(burst_end, to_byte) - 1 - from_byte) // pixel_bytes
        first = (start - from_byte) // pixel_bytes
        return start, words, scanned[which] + last, scanned[which] + first + slack

    count = int(until[-1])
    return FrameWrites(count, lambda: (part(np.arange(first, min(first + _PIECE, count)))
                                       for first in range(0, count, _PIECE)))
