"""Common parts of runs of many frames: addresses in memory, a frame begun, pixels that differ."""

import numpy as np

from ncdc_spec.frames import BGRX8, frame_bytes, stored_bytes
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START

__all__ = ["aligned", "begin", "differing", "output_bytes", "read_measured"]

_ALIGN = 4096       # bytes; frames in memory begin at multiples of this


def aligned(size):
    """Bytes up to the next address where a frame may begin, ``size`` or more."""
    return -(-size // _ALIGN) * _ALIGN


def begin(program, rows, values):
    """Write ``values`` by register name, ``rows`` are the addresses; commit and start."""
    for name, value in values.items():
        program.write(rows[name], value)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)


def read_measured(program, table):
    """Read each register of ``table`` that no host can write, or whose bits are flags."""
    for register in table:
        if register.access in ("ro", "action"):
            program.read(register.address)


def output_bytes(geometry, stream, form=BGRX8):
    """Bytes of a corrected frame in a run's output: of a stream three per pixel, else as the
    :class:`OutputFormat` ``form`` has it."""
    pixels = geometry.corrected_width * geometry.corrected_height
    return 3 * pixels if stream else frame_bytes(geometry, form)


def differing(output, begins, goldens, stream, form=BGRX8):
    """Pixels that differ from the golden picture (height, width, 3), of each frame, as a tuple.

    ``begins``: where each frame begins in the run's ``output``. All bytes of a pixel count.
    """
    counts = []
    for start, golden in zip(begins, goldens, strict=True):
        expected = golden if stream else stored_bytes(golden, form)
        got = np.frombuffer(output, np.uint8, expected.size, start).reshape(expected.shape)
        counts.append(int((got != expected).any(axis=2).sum()))
    return tuple(counts)
