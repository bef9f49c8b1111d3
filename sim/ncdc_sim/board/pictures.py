"""Pictures out of what a gigabit line carried: whole or not, when, and how many pixels differ."""

import struct
import zlib
from dataclasses import dataclass

import numpy as np

from ncdc_sim.tools import SimulationError
from ncdc_spec.protocols import gvsp

__all__ = ["GAP_CLOCKS", "Picture", "Steady", "line_frames", "pictures_of", "steady"]

GAP_CLOCKS = 12             # of the line between two frames, at least: 96 bits
_RECORD = struct.Struct(">IIHH")
_PREAMBLE = bytes([0x55] * 7 + [0xD5])
_HEADERS = 14 + 20 + 8      # Ethernet, IP, UDP
_PART = struct.Struct(">HHI")


@dataclass(frozen=True)
class LineFrame:
    """An Ethernet frame on the line: clocks of the line, data, and whether it is valid.

    The clocks are that of the first byte and that after the last one. The data are without preamble
    and check sequence.
    """
    begin: int
    end: int
    data: bytes
    whole: bool


@dataclass(frozen=True)
class Picture:
    """A picture of GVSP: its number, the line's clock after its last byte, its bytes.

    The bytes are None if packets are missing, come twice or in another order.
    """
    block: int
    end: int
    data: bytes | None


def line_frames(record):
    """List of :class:`LineFrame` of a record of ``hdl/network_bench.v``.

    A frame is not whole if its preamble or check sequence is wrong, or the gap before it is too
    short. Nor is it with a byte that is signalled as wrong, as one is that came too late.
    """
    frames, at, quiet = [], 0, 0
    while at < len(record):
        begin, end, length, wrong = _RECORD.unpack_from(record, at)
        at += _RECORD.size
        data = record[at:at + length]
        at += length
        body, check = data[len(_PREAMBLE):-4], data[-4:]
        whole = (not wrong and data.startswith(_PREAMBLE) and begin >= quiet
                 and zlib.crc32(body).to_bytes(4, "little") == check)
        frames.append(LineFrame(begin, end, body, whole))
        quiet = end + GAP_CLOCKS
    return frames


def pictures_of(frames):
    """List of :class:`Picture` of frames that are all a GVSP stream's, those that are not whole
    being dropped, as a receiver does."""
    parts = {}              # (format, packet number) and the frame, by the picture's number
    for frame in frames:
        if frame.whole:
            _, block, word = _PART.unpack_from(frame.data, _HEADERS)
            parts.setdefault(block, []).append(((word >> 24, word & 0xFFFFFF), frame))
    pictures = []
    for block, received in parts.items():
        last = len(received) - 1
        complete = [(gvsp.LEADER, 0), *((gvsp.PAYLOAD, k) for k in range(1, last)),
                    (gvsp.TRAILER, last)]
        data = None
        if [key for key, _ in received] == complete:
            data = b"".join(_payload(frame.data) for _, frame in received[1:-1])
        pictures.append(Picture(block, received[-1][1].end, data))
    return pictures


def _payload(data):
    """The bytes of a payload packet that are picture: a short frame was filled up."""
    length = struct.unpack_from(">H", data, 14 + 20 + 4)[0]     # of UDP
    return data[_HEADERS + _PART.size:14 + 20 + length]


@dataclass(frozen=True)
class Steady:
    """Figures of consecutive pictures.

    Parameters
    ----------
    frames : int
        Number of frames that were timed.
    pixels_different : int
        From the pictures that they have to be, of all pictures together; of one that is not whole
        all.
    frames_per_second, slowest : float
        From last byte to last byte, of all and of the two that lie furthest apart.
    megabytes_per_second : float
        Rate of picture data.
    """
    frames: int
    pixels_different: int
    frames_per_second: float
    slowest: float
    megabytes_per_second: float


def steady(pictures, expected, line_hz, settle):
    """:class:`Steady` of pictures, time being taken from the end of number ``settle`` on.

    Parameters
    ----------
    pictures : sequence of Picture
    expected : sequence of ndarray of uint8, shape (height, width, bytes of a pixel)
        Expected pictures.
    line_hz : number
    settle : int
        At least 1.

    Raises
    ------
    SimulationError
        If fewer than two pictures are left, or there are not as many as expected.
    """
    if len(pictures) < settle + 2 or len(pictures) != len(expected):
        raise SimulationError(f"{len(pictures)} pictures came, {len(expected)} were sent, "
                              f"{settle + 2} are needed")
    times = np.diff([picture.end for picture in pictures[settle - 1:]]) / line_hz
    return Steady(
        len(times),
        sum(_different(picture.data, golden) for picture, golden in zip(pictures, expected)),
        float(1 / times.mean()), float(1 / times.max()),
        float(expected[0].nbytes / times.mean() / 1e6))


def _different(data, golden):
    """Pixels of a picture's bytes that differ from the golden ones."""
    if data is None or len(data) != golden.nbytes:
        return golden[..., 0].size
    return int((np.frombuffer(data, np.uint8).reshape(golden.shape) != golden).any(axis=-1).sum())
