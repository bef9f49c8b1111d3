"""Reads of a screen or a network while a frame is corrected."""

from dataclasses import dataclass, replace
from fractions import Fraction
from heapq import merge
from itertools import count

from ncdc_model.planner.writes import FrameWrites

__all__ = ["BURST", "SteadyReads", "with_reads"]

BURST = 16              # words that a reader asks for at once


@dataclass(frozen=True)
class SteadyReads:
    """Reads of corrected pictures at a constant rate, from the beginning of a frame on.

    Parameters
    ----------
    base, size : int
        Byte address of a picture, a multiple of a word, and its bytes.
    rate : Fraction
        Bytes per clock of the corrector.
    """
    base: int
    size: int
    rate: Fraction

    def accesses(self, word, block):
        """(edge, address, words) of each access, an endless sequence.

        Words have ``word`` bytes; an access does not cross the borders of blocks of ``block``
        bytes. A burst is asked for when the one before it is used up.
        """
        block, burst = max(block, word), BURST * word
        read = 0
        for first in count():
            begin = first * burst % -(-self.size // burst * burst)
            edge = int(read / self.rate)
            address, stop = self.base + begin, self.base + min(begin + burst, self.size)
            read += stop - address
            while address < stop:
                upto = min(stop, (address // block + 1) * block)
                yield edge, address, -(-(upto - address) // word)
                address = upto


def with_reads(writes, readers, word, block):
    """``writes``, :class:`FrameWrites` or None for a stream, with the reads of all ``readers``,
    :class:`SteadyReads`; parameters as of :meth:`SteadyReads.accesses`."""
    if not readers:
        return writes
    return replace(writes or FrameWrites(),
                   reads=lambda: merge(*(each.accesses(word, block) for each in readers)))
