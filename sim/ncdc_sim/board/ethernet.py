"""Frames on a board's Ethernet cable in simulation."""

import struct
import zlib
from dataclasses import dataclass
from pathlib import Path

from ncdc_sim.tools import SimulationError
from ncdc_soc.board import ProcessorFiles

__all__ = ["Ethernet", "Passed", "passed"]

_RECORD = struct.Struct(">IH")      # microsecond, bytes
_PREAMBLE = bytes([0x55] * 7 + [0xD5])
_SHORTEST = 60                      # bytes of a frame without its check sequence


@dataclass(frozen=True)
class Passed:
    """A frame on the cable, without preamble and check sequence, and the microsecond of its
    beginning."""
    us: int
    data: bytes


@dataclass(frozen=True)
class Ethernet:
    """A board's processor, and what its cable brings.

    Parameters
    ----------
    files : ProcessorFiles
    received : sequence of Passed
        In the order of their times. Short ones are filled up.
    """
    files: ProcessorFiles
    received: tuple = ()

    def fill(self, folder):
        """Write what ``hdl/rgmii_chip.v`` and the processor's memories read into a folder."""
        for name, text in self.files.memories.items():
            (Path(folder) / name).write_text(text)
        (Path(folder) / "rx.bin").write_bytes(b"".join(map(_record, self.received)))


def _record(frame):
    data = frame.data.ljust(_SHORTEST, b"\0")
    data += zlib.crc32(data).to_bytes(4, "little")
    return _RECORD.pack(frame.us, len(data)) + data


def passed(record):
    """The :class:`Passed` frames of a record of ``hdl/rgmii_chip.v``.

    Raises
    ------
    SimulationError
        If a frame begins without its preamble, or its check sequence is wrong.
    """
    frames, at = [], 0
    while at < len(record):
        us, length = _RECORD.unpack_from(record, at)
        at += _RECORD.size
        data = record[at:at + length]
        at += length
        body, check = data[len(_PREAMBLE):-4], data[-4:]
        if not data.startswith(_PREAMBLE):
            raise SimulationError(f"a frame at {us} us begins with {data[:8].hex()}")
        if zlib.crc32(body).to_bytes(4, "little") != check:
            raise SimulationError(f"the check sequence of a frame at {us} us is wrong")
        frames.append(Passed(us, body))
    return frames
