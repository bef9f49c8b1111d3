"""Writes of a running camera while a frame is corrected."""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import count

from ncdc_model.planner.writes import FrameWrites

__all__ = ["CameraWrites"]


@dataclass(frozen=True)
class CameraWrites:
    """Writes of raw frames while one is corrected, from the end of the last frame on.

    Parameters
    ----------
    base, pitch : int
        Byte address of the raw frame, bytes from row to row.
    width, height : int
        Samples of a row, rows.
    sample : Fraction
        Clocks of the corrector per sample.
    line, frame : Fraction
        Clocks per row and per frame, blanking included.
    burst : int
        Words of a burst, at most.
    latency : int
        Clocks from the last sample of a burst to its first word on the bus.
    """
    base: int
    pitch: int
    width: int
    height: int
    sample: Fraction
    line: Fraction
    frame: Fraction
    burst: int
    latency: int

    @classmethod
    def of(cls, timing, ratio, geometry, base, pitch, *, burst, latency):
        """Writes of a sensor with ``timing``; ``ratio``: corrector clocks per pixel clock."""
        return cls(base, pitch, *geometry.distorted, ratio, timing.line_clocks * ratio,
                   timing.frame_clocks * ratio, burst, latency)

    def accesses(self, word, block):
        """(edge, address, words) of each access, an endless sequence.

        Words have ``word`` bytes; an access does not cross the borders of blocks of ``block``
        bytes. The previous frame is complete at edge 0.
        """
        block, size = max(block, word), self.burst * word
        # The last row of the previous frame ends at 0; its rows are `line` apart.
        blank = self.frame - (self.height - 1) * self.line - self.width * self.sample
        for number in count():
            for row in range(self.height):
                begin = number * self.frame + blank + row * self.line
                for first in range(0, self.width, size):
                    end = min(first + size, self.width)
                    edge = int(begin + end * self.sample) + self.latency
                    address = self.base + row * self.pitch + first
                    stop = address + -(-(end - first) // word) * word
                    while address < stop:
                        upto = min(stop, (address // block + 1) * block)
                        edge += (upto - address) // word
                        yield edge, address, (upto - address) // word
                        address = upto

    def merged_with(self, writes, word, block):
        """``writes``, :class:`FrameWrites` or None for a stream, with these on the same port."""
        return replace(writes or FrameWrites(), others=lambda: self.accesses(word, block))
