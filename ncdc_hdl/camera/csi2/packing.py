"""Where the samples of a row lie in its payload, and when they can leave: no gateware."""

from dataclasses import dataclass
from math import gcd

__all__ = ["Packing"]

_BYTE = 8


@dataclass(frozen=True)
class Packing:
    """A payload of samples of 8, 10 or 12 bits, in words of one byte per lane.

    A group is a byte of each sample's upper bits, then a byte of the lower bits of all of them,
    the first sample's lowest. Samples of 8 bits have no lower ones. Groups and words begin
    together once in a period. An output is one sample per lane.

    Parameters
    ----------
    bits : int
        Bits of a sample.
    lanes : int
        A power of two.
    wait : int
        Words by which each output is later than it could be.
    """
    bits: int
    lanes: int
    wait: int = 0

    @property
    def low_bits(self):
        """Number of lower bits of a sample."""
        return self.bits - _BYTE

    @property
    def group_samples(self):
        """Samples of a group, which is also the number of outputs in a period."""
        return _BYTE // gcd(_BYTE, self.low_bits)

    @property
    def group_bytes(self):
        """Bytes of a group, an odd number, which is also the number of words in a period."""
        return self.group_samples * self.bits // _BYTE

    def upper(self, sample):
        """Number of the byte with the upper bits of a sample, in a period as the sample."""
        group, number = divmod(sample, self.group_samples)
        return group * self.group_bytes + number

    def lower(self, sample):
        """(number of the byte with the lower bits of a sample, the lowest one of these)."""
        group, number = divmod(sample, self.group_samples)
        return (group + 1) * self.group_bytes - 1, number * self.low_bits

    @property
    def times(self):
        """Number of the word with which each output of a period leaves, the first word being 0.

        It is the word of the output's last byte, or the word after that of the output before.
        """
        times = []
        for output in range(self.group_samples):
            ready = self.lower((output + 1) * self.lanes - 1)[0] // self.lanes
            times.append(max([ready, *(time + 1 for time in times[-1:])]))
        return [time + self.wait for time in times]

    def output_at(self, word):
        """Number of the output that leaves with a word of the period, or None."""
        leaving = {time % self.group_bytes: output for output, time in enumerate(self.times)}
        return leaving.get(word)

    def end(self, word, rest):
        """What a row still gives if its last byte is in a word of the period.

        Parameters
        ----------
        word : int
        rest : int
            Number of bytes in that word modulo ``lanes``.

        Returns
        -------
        (int, int) or None
            Words until the last output leaves, and number of samples in it modulo ``lanes``.
            None if the bytes are no whole groups.
        """
        groups, more = divmod(word * self.lanes + (rest or self.lanes), self.group_bytes)
        if more:
            return None
        samples = groups * self.group_samples
        return self.times[(samples - 1) // self.lanes] - word, samples % self.lanes
