"""What runs of many frames in a row share: places in memory, a set begun, pixels that differ."""

import numpy as np

from ncdc_model.interface.frames import PIXEL_BYTES, stored_picture
from ncdc_model.interface.register_map import CTRL_COMMIT, CTRL_START

__all__ = ["aligned", "begin", "differing", "output_bytes"]

_ALIGN = 4096       # bytes; frames in memory begin at multiples of this


def aligned(size):
    """Bytes up to the next place where a frame may begin, ``size`` or more."""
    return -(-size // _ALIGN) * _ALIGN


def begin(program, rows, values):
    """Write ``values`` by register name, ``rows`` are the addresses; commit and start."""
    for name, value in values.items():
        program.write(rows[name], value)
    program.write(rows["CTRL"], CTRL_COMMIT | CTRL_START)


def output_bytes(geometry, stream):
    """Bytes of a corrected frame in a run's output: of a stream three per pixel."""
    pixels = geometry.corrected_width * geometry.corrected_height
    return pixels * (3 if stream else PIXEL_BYTES)


def differing(output, places, goldens, stream):
    """Pixels that differ from the golden picture (height, width, 3), of each frame, as a tuple.

    ``places``: where each frame begins in the run's ``output``.
    """
    counts = []
    for place, golden in zip(places, goldens, strict=True):
        height, width, _ = golden.shape
        step = 3 if stream else PIXEL_BYTES
        got = np.frombuffer(output, np.uint8, height * width * step, place)
        got = got.reshape(height, width, step)
        got = got if stream else stored_picture(got)
        counts.append(int((got != golden).any(axis=2).sum()))
    return tuple(counts)
