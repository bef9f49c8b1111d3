"""Frames and sync times of a monitor, from its record of each pixel clock."""

from dataclasses import dataclass

import numpy as np

from ncdc_sim.tools import SimulationError

__all__ = ["Screen", "screen_of"]

_VISIBLE, _HSYNC, _VSYNC = 1, 2, 4


@dataclass(frozen=True)
class Screen:
    """The whole frames that a monitor saw.

    Parameters
    ----------
    frames : list of ndarray of uint8, shape (height, width, 3)
        Red, green, blue.
    horizontal, vertical : set of tuple
        Visible, front porch, sync pulse, back porch: in pixel clocks of each line, and in lines of
        each frame. One entry if all are alike.
    high : (bool, bool)
        Whether HSYNC and VSYNC are high in their pulses.
    """
    frames: list
    horizontal: set
    vertical: set
    high: tuple


def screen_of(record):
    """The :class:`Screen` of a record, bytes as ``hdl/dvi_monitor.v`` writes them.

    Lines before the first frame's beginning and after the last one's end are left out.

    Raises
    ------
    SimulationError
        If there is no whole frame, or lines of a frame differ in length.
    """
    clocks = np.frombuffer(record, np.uint8).reshape(-1, 4)
    visible = (clocks[:, 3] & _VISIBLE) > 0
    lines = np.flatnonzero(visible & ~np.r_[True, visible[:-1]])    # where lines begin
    if not len(lines):
        raise SimulationError("the monitor saw no visible pixel")
    # A frame begins with the first line after a gap longer than a line's.
    gaps = np.diff(lines)
    begins = lines[1:][gaps > gaps.min()]
    if len(begins) < 2:
        raise SimulationError(f"the monitor saw {len(begins)} beginnings of frames, two make one")
    line = int(gaps.min())
    high = tuple(_polarity(clocks, visible, bit) for bit in (_HSYNC, _VSYNC))
    frames, horizontal, vertical = [], set(), set()
    for begin, end in zip(begins, begins[1:]):
        if (end - begin) % line:
            raise SimulationError(f"a frame has {end - begin} pixel clocks, its lines {line}")
        part = clocks[begin:end].reshape(-1, line, 4)
        seen = visible[begin:end].reshape(-1, line)
        # The levels while pixels are visible are those of the blanking around them: none.
        hsync, vsync = (((part[:, :, 3] & bit) > 0) == up for bit, up in
                        zip((_HSYNC, _VSYNC), high))
        hsync, vsync = hsync & ~seen, vsync & ~seen
        rows = seen.any(axis=1)
        horizontal |= {_parts(seen_line, pulse) for seen_line, pulse in zip(seen[rows],
                                                                           hsync[rows])}
        vertical.add(_parts(rows, vsync.any(axis=1)))
        frames.append(part[rows][:, seen[rows][0], :3])
    return Screen(frames, horizontal, vertical, high)


def _polarity(clocks, visible, bit):
    """Whether a sync signal is high for less than half of the blanking."""
    blank = clocks[~visible, 3]
    return bool(((blank & bit) > 0).mean() < .5)


def _parts(visible, pulse):
    """Lengths of the visible part, front porch, pulse and back porch of a line or frame."""
    at = np.flatnonzero(pulse)
    if not len(at) or not visible[0]:
        return (int(visible.sum()), 0, 0, 0)
    shown, begin, length = int(visible.sum()), int(at[0]), len(at)
    return shown, begin - shown, length, len(visible) - begin - length
