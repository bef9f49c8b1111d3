"""What a running camera writes while a frame is corrected."""

from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import count

from ncdc_model.planner.writes import FrameWrites

__all__ = ["CameraWrites"]


@dataclass(frozen=True)
class CameraWrites:
    """The raw frames that come while one is corrected, which begins when the last one is complete.

    Parameters
    ----------
    base, pitch : int
        Byte address of the raw frame, bytes from row to row.
    width, height : int
        Samples of a row, rows.
    sample : Fraction
        Clocks of the corrector from sample to sample.
    line, frame : Fraction
        Clocks from row to row and from frame to frame.
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
        """Those of a sensor's ``timing``; ``ratio``: clocks of the corrector per pixel clock."""
        return cls(base, pitch, *geometry.distorted, ratio, timing.line_clocks * ratio,
                   timing.frame_clocks * ratio, burst, latency)

    def accesses(self, word, block):
        """(edge, address, words) of each access, one after the other without end; words of ``word``
        bytes, in blocks of ``block`` bytes that an access does not leave. Edge 0 is that at which
        the frame before is complete."""
        block, size = max(block, word), self.burst * word
        # The last row of the frame before ends at 0; its rows are `line` apart.
        blank = self.frame - (self.height - 1) * self.line - self.width * self.sample
        for number in count():
            for row in range(self.height):
                begin = number * self.frame + blank + row * self.line
                for first in range(0, self.width, size):
                    end = min(first + size, self.width)
                    edge = int(begin + end * self.sample) + self.latency
                    place = self.base + row * self.pitch + first
                    stop = place + -(-(end - first) // word) * word
                    while place < stop:
                        upto = min(stop, (place // block + 1) * block)
                        edge += (upto - place) // word
                        yield edge, place, (upto - place) // word
                        place = upto

    def beside(self, writes, word, block):
        """``writes``, :class:`FrameWrites` or None for a stream, with these on the same port."""
        return replace(writes or FrameWrites(), others=lambda: self.accesses(word, block))
