"""Whether the file of a film ends before the end that its format states."""

import os
import struct

from ncdc_model.photo.kinds import HEAD, TRANSPORT, film_of

__all__ = ["ends_early"]

_TS_PACKETS = 188, 192, 204     # bytes; a transport stream has whole ones only
_MATROSKA = b"\x1aE\xdf\xa3"
_BOXES = b"ftyp", b"moov", b"mdat", b"moof", b"free", b"wide", b"skip", b"styp", b"sidx"


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
            return _end(file, size, "<4xI", 8, (b"RIFF",)) > size
        if head[4:8] in _BOXES:
            return _end(file, size, ">I", 0, _BOXES) > size
        return film_of(head) == TRANSPORT and all(size % one for one in _TS_PACKETS)


def _end(file, size, form, extra, known):
    """Where the last of the top chunks of a file ends; ``extra`` bytes are not in their length."""
    at = 0
    while at + 8 <= size:
        file.seek(at)
        head = file.read(16)
        name = head[:4] if extra else head[4:8]
        if name not in known:
            return at               # padding, or a box that no film needs
        length = struct.unpack_from(form, head)[0] + extra
        if length == 1 and len(head) == 16:
            length = struct.unpack_from(">8xQ", head)[0]
        if length < 8:
            return size             # up to the end
        at += length + (length % 2 if extra else 0)
    return at


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
