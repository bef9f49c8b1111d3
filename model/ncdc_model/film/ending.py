"""Whether the file of a film ends before the end that its format states."""

import io
import os
import struct

from ncdc_model.photo.kinds import HEAD, packet_of

__all__ = ["WholeBoxes", "ends_early"]

_MATROSKA = b"\x1aE\xdf\xa3"
_BOXES = b"ftyp", b"moov", b"mdat", b"moof", b"free", b"wide", b"skip", b"styp", b"sidx", b"mfra"


def ends_early(path):
    """Whether the file ``path`` is shorter than the lengths in it say.

    Known are the boxes of MP4 and QuickTime, the chunks of AVI, the elements of Matroska and
    WebM, and the packets of a transport stream. A format that states no length gives False.
    """
    size = os.path.getsize(path)
    with open(path, "rb") as file:
        head = file.read(HEAD)
        if head[:4] == _MATROSKA:
            return _matroska_end(file) > size
        if head[:4] == b"RIFF":
            return _ends(file, size, "<4xI", 8, (b"RIFF",))[-1] > size
        if head[4:8] in _BOXES:
            return _ends(file, size, ">I", 0, _BOXES)[-1] > size
        packet = packet_of(head)
        return bool(packet and size % packet)


class WholeBoxes(io.FileIO):
    """The file of a film in MP4 or QuickTime, without the box in which it is cut off.

    A film of many fragments, as recorders write it, can be played up to there.
    """

    def __init__(self, path):
        super().__init__(path)
        self._size = size = os.path.getsize(path)
        self._size = max(end for end in _ends(self, size, ">I", 0, _BOXES) if end <= size)
        self.seek(0)

    def read(self, size=-1):
        """Up to ``size`` bytes."""
        left = max(0, self._size - self.tell())
        return super().read(left if size < 0 else min(size, left))

    def seek(self, offset, whence=os.SEEK_SET):
        """Go to a place, from the beginning, from here or from the end of the last whole box."""
        if whence == os.SEEK_END:
            return super().seek(self._size + offset)
        return super().seek(offset, whence)


def _ends(file, size, form, extra, known):
    """Where the top chunks of a file end; ``extra`` bytes are not in the length that they state."""
    ends, at = [0], 0
    while at + 8 <= size:
        file.seek(at)
        head = file.read(16)
        if (head[:4] if extra else head[4:8]) not in known:
            break                   # padding, or a box that no film needs
        length = struct.unpack_from(form, head)[0] + extra
        if length == 1 and len(head) == 16:
            length = struct.unpack_from(">8xQ", head)[0]
        if length < 8:
            break                   # up to the end
        at += length + (length % 2 if extra else 0)
        ends.append(at)
    return ends


def _matroska_end(file):
    """Where the segment ends, or 0 if it does not say."""
    file.seek(4)
    length = _number(file)
    file.seek(length, os.SEEK_CUR)
    if file.read(4) != b"\x18S\x80g":
        return 0
    length = _number(file)
    return 0 if length is None else file.tell() + length


def _number(file):
    """A length of variable size at the place of a file, or None if all its bits are set."""
    first = file.read(1)[0]
    more = 8 - first.bit_length()
    value = int.from_bytes(bytes([first & (0x7f >> more)]) + file.read(more))
    return None if value == (1 << 7 * (more + 1)) - 1 else value
