"""Samples of a sensor in files: how many of their bits hold light, and dumps without a header."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.errors import InputError
from ncdc_model.files import read_bytes
from ncdc_model.geometry import BAYERS, MAX_SIZE, MIN_SIZE

__all__ = ["RawDump", "check_bits", "eight_bits"]

BITS = 8, 16           # least and most bits of a sample
_USUAL = 8, 10, 12, 14, 16


def check_bits(bits):
    """``bits`` of a sample; raises :class:`InputError` outside 8 to 16."""
    if not BITS[0] <= bits <= BITS[1]:
        raise InputError(f"samples of {bits} bits are asked for, the limits are {BITS[0]} and "
                         f"{BITS[1]}")
    return bits


def eight_bits(samples, bits, name, told):
    """The upper eight of the ``bits`` bits of ``samples``, uint8 or uint16, as uint8.

    Sensors of 10 or 12 bits are written to files of 16 with zeros above. If ``bits`` is None, the
    least usual number that holds the brightest sample is taken, and ``told`` is called with a
    sentence that says so.

    Raises
    ------
    InputError
        If ``bits`` is out of range or a sample needs more.
    """
    peak = int(samples.max(initial=0))
    if bits is None and samples.dtype == np.uint8:
        return samples
    if bits is None:
        bits = next(count for count in _USUAL if peak < 1 << count)
        told(f"{name} has 16-bit samples, the brightest is {peak}: taken as {bits}-bit; "
             f"--bits says otherwise")
    if peak >> check_bits(bits):
        raise InputError(f"{name} holds a sample of {peak}, {bits} bits end at {(1 << bits) - 1}")
    return (samples >> (bits - 8)).astype(np.uint8)


@dataclass(frozen=True)
class RawDump:
    """What a file of bare samples, row by row, does not say itself.

    Samples of 8 bits are bytes; of 9 to 16 bits two bytes each, the lower first, zeros above.
    """
    width: int
    height: int
    bayer: str
    bits: int

    @classmethod
    def parse(cls, text):
        """Of "WxH:PATTERN:BITS"; raises :class:`InputError` if ``text`` says anything else."""
        size, _, rest = text.partition(":")
        bayer, _, bits = rest.partition(":")
        sides = size.lower().split("x")
        if (len(sides) != 2 or not all(part.isdecimal() for part in (*sides, bits))
                or bayer.upper() not in BAYERS):
            raise InputError(f"raw is {text!r}, WxH:PATTERN:BITS is needed, as in "
                             f"1280x1024:RGGB:12; the patterns are {', '.join(BAYERS)}")
        for side in map(int, sides):
            if not MIN_SIZE <= side <= MAX_SIZE:
                raise InputError(f"a side of the raw frame is {side}, the limits are {MIN_SIZE} "
                                 f"and {MAX_SIZE}")
        return cls(*map(int, sides), bayer.upper(), check_bits(int(bits)))

    def read(self, path):
        """Frame of the file ``path``: uint8 (height, width), its upper eight bits.

        Raises
        ------
        InputError
            If the file cannot be read, has another length, or holds a sample of more bits.
        """
        content, size = read_bytes(path), 1 if self.bits == 8 else 2
        wanted = self.width * self.height * size
        if len(content) != wanted:
            raise InputError(f"{path} has {len(content)} bytes, {self.width}x{self.height} samples "
                             f"of {size} byte{'s' if size > 1 else ''} need {wanted}; packed "
                             f"samples are not read")
        samples = np.frombuffer(content, f"<u{size}").reshape(self.height, self.width)
        return eight_bits(samples, self.bits, path, None)
