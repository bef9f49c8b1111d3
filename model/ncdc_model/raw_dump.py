"""Dumps of samples without a header, plain or packed as MIPI CSI-2 sends them."""

import re
from dataclasses import dataclass

import numpy as np

from ncdc_model.samples import check_bits, eight_bits
from ncdc_spec.errors import InputError
from ncdc_spec.files import read_bytes
from ncdc_spec.geometry import BAYERS, MAX_SIZE, MIN_SIZE

__all__ = ["RawDump"]

# Bits of a packed sample: samples and bytes of a group. MIPI CSI-2 (RAW10, RAW12, RAW14) sends the
# upper eight bits of each sample as a byte, then the lower bits of all of them.
_PACKED = {10: (4, 5), 12: (2, 3), 14: (4, 7)}
_FORM = re.compile(r"(\d+)x(\d+):([A-Za-z]+):(\d+)(p?)((?::(?:stride|frame)=\d+)*)")


@dataclass(frozen=True)
class RawDump:
    """Format of a file of samples, row by row, without a header.

    Samples of 8 bits are bytes. Samples of 9 to 16 bits are two bytes each, the lower first, with
    zeros above, or ``packed``. A row takes ``stride`` bytes; None: those of its samples. ``frame``,
    counted from 1, chooses one of several frames; None: the first, with a warning.
    """
    width: int
    height: int
    bayer: str
    bits: int
    packed: bool = False
    stride: int | None = None
    frame: int | None = None

    @classmethod
    def parse(cls, text):
        """Dump described by "WxH:PATTERN:BITS[p][:stride=N][:frame=K]".

        Raises
        ------
        InputError
            If ``text`` has another form, or a number is out of range.
        """
        match = _FORM.fullmatch(text)
        options = [part.split("=") for part in match[6].split(":")[1:]] if match else []
        if not match or match[3].upper() not in BAYERS or len(dict(options)) != len(options):
            raise InputError(f"raw is {text!r}, WxH:PATTERN:BITS is needed, as in "
                             f"1280x1024:RGGB:12, 1280x1024:RGGB:10p:stride=1664:frame=2; the "
                             f"patterns are {', '.join(BAYERS)}")
        width, height, bits = int(match[1]), int(match[2]), check_bits(int(match[4]))
        for side in (width, height):
            if not MIN_SIZE <= side <= MAX_SIZE:
                raise InputError(f"a side of the raw frame is {side}, the limits are {MIN_SIZE} "
                                 f"and {MAX_SIZE}")
        if match[5] and bits not in _PACKED:
            raise InputError(f"packed samples of {bits} bits are asked for, those of "
                             f"{', '.join(map(str, _PACKED))} bits are read")
        dump = cls(width, height, match[3].upper(), bits, bool(match[5]),
                   **{name: int(value) for name, value in options})
        if dump.stride is not None and dump.stride < dump.row_bytes:
            raise InputError(f"the stride is {dump.stride} bytes, the samples of a row need "
                             f"{dump.row_bytes}")
        if dump.frame == 0:
            raise InputError("the frame is 0, frames are counted from 1")
        return dump

    @property
    def row_bytes(self):
        """Bytes of the samples of a row, without the padding up to the stride."""
        return _row_bytes(self.width, self.bits, self.packed)

    @property
    def frame_bytes(self):
        """Bytes of a frame."""
        return (self.stride or self.row_bytes) * self.height

    def read(self, path, warn):
        """Frame of the file ``path``: uint8 (height, width), its upper eight bits.

        ``warn`` is called with a sentence if the file has several frames and none is chosen.

        Raises
        ------
        InputError
            If the file cannot be read, has no length of whole frames, has no frame of that
            number, or holds a sample of more bits.
        """
        content = read_bytes(path)
        first = (self._number(path, content, warn) - 1) * self.frame_bytes
        return self.unpacked(content[first:first + self.frame_bytes], path, warn)

    def unpacked(self, content, name, warn):
        """Frame of ``content``, :attr:`frame_bytes` bytes: uint8 (height, width), upper eight bits.

        ``warn``: as of :meth:`read`.

        Raises
        ------
        InputError
            If it holds a sample of more bits; ``name`` says in which file.
        """
        rows = np.frombuffer(content, np.uint8).reshape(self.height, -1)[:, :self.row_bytes]
        if self.packed:
            samples, size = _PACKED[self.bits]
            groups = rows.reshape(self.height, -1, size)[:, :, :samples]
            return np.ascontiguousarray(groups.reshape(self.height, -1)[:, :self.width])
        if self.bits == 8:
            return np.ascontiguousarray(rows)
        return eight_bits(np.ascontiguousarray(rows).view("<u2"), None, self.bits, name, warn)

    def _number(self, path, content, warn):
        """Number of the frame of ``content`` to read, from 1; checks the length of the file."""
        length = self.frame_bytes
        count, rest = divmod(len(content), length)
        # Two frames of 8 bits have the length of one of two bytes a sample: the user must choose.
        if rest or not count or count == 2 and self.bits == 8 and self.frame is None:
            raise InputError(f"{path} has {len(content)} bytes, {self._wanted(length)}"
                             + self._hint(content))
        if self.frame is None and count > 1:
            warn(f"{path}: the first of {count} frames is taken; :frame=2 in --raw takes the "
                 f"second")
        if (self.frame or 1) > count:
            raise InputError(f"{path} holds {count} frame{'s'[:count > 1]}, frame {self.frame} is "
                             f"asked for")
        return self.frame or 1

    def _wanted(self, length):
        if self.stride is not None:
            return f"{self.height} rows of {self.stride} bytes need {length}"
        size = 1 if self.bits == 8 else 2
        each = (f"packed samples of {self.bits} bits" if self.packed else
                f"samples of {size} byte{'s'[:size > 1]}")
        return f"{self.width}x{self.height} {each} need {length}"

    def _hint(self, content):
        """Text on formats that the length of ``content`` fits, or on the lengths of one frame."""
        if content[:6] == b"\x93NUMPY":
            return "; it is a NumPy file, which is read without --raw"
        lengths = {name: _row_bytes(self.width, bits, packed) * self.height
                   for name, bits, packed in (("8", 8, False), ("9 to 16", 16, False),
                                              *((f"{n}p", n, True) for n in _PACKED))}
        fits = [name for name, length in lengths.items() if length == len(content)]
        if fits:
            return f"; that is one frame of {fits[0]} bits" + (
                ", or two of 8 (:frame=1)" if self.bits == 8 and fits == ["9 to 16"] else "")
        if len(content) % self.height == 0 and len(content) // self.height > self.row_bytes:
            return f"; rows of {len(content) // self.height} bytes would fit (:stride=)"
        return "; by bits: " + ", ".join(f"{name} {length}" for name, length in lengths.items())


def _row_bytes(width, bits, packed):
    if packed:
        samples, size = _PACKED[bits]
        return -(-width // samples) * size
    return width * (1 if bits == 8 else 2)
