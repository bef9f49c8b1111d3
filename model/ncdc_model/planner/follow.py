"""Bound of the latency from the camera's last byte to the end of the frame, with early start."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.planner.camera_writes import CameraWrites
from ncdc_model.planner.lookups import frame_windows, lookups, pieces
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_model.planner.writes import frame_writes
from ncdc_spec.errors import InputError
from ncdc_spec.frames import FrameAddresses
from ncdc_spec.interpolation import FAST

__all__ = ["FollowBound", "camera_line", "follow_bound", "rows_needed"]

_ERROR = .01            # of the predicted clocks, see ``predict_clocks``


@dataclass(frozen=True)
class FollowBound:
    """Bound of the latency for a map, a camera and a memory.

    Parameters
    ----------
    clocks : int
        From the camera's last byte in memory to the frame's end, at most; negative if the
        corrected frame does not need the last rows.
    camera_clocks : int
        From the camera's first byte to its last one.
    pixel : int
        Pixel, in the order of the scan, that determines the bound.
    rows : int
        Rows of the raw frame that must be in memory for that pixel.
    """
    clocks: int
    camera_clocks: int
    pixel: int
    rows: int

    @property
    def share(self):
        """The clocks as a share of the camera's frame."""
        return self.clocks / self.camera_clocks

    def report(self):
        """The figures under their names in every report."""
        return {"follow_bound_clocks": self.clocks, "follow_bound_share": self.share,
                "camera_clocks": self.camera_clocks}


def camera_line(line, geometry):
    """Clocks of a camera's row: ``line``, by default one per sample.

    Raises
    ------
    InputError
        If ``line`` is outside its limits.
    """
    if line is None:
        return geometry.distorted_width
    if not geometry.distorted_width <= line < 1 << 16:
        raise InputError(f"a row of the camera takes {line} clocks, the limits are "
                         f"{geometry.distorted_width} and 65535")
    return line


def rows_needed(y0, used, height, interpolation=FAST):
    """Rows of a raw frame of ``height`` rows that must be in memory for windows with first corners
    in row y0: up to the end of the tiles of their last rows; 0 where not ``used``."""
    last = (np.asarray(y0) + interpolation.after) | (interpolation.tile_height - 1)
    return np.where(used, np.minimum(last + 1, height), 0)


def _rows(camera, geometry):
    """Clocks of a camera per row, from a row's first sample to its last, and from there until
    `camera_rows` counts it: a clock after its last byte is in memory."""
    if not isinstance(camera, CameraWrites):
        return camera_line(camera, geometry), geometry.distorted_width, 1
    return camera.line, camera.width * camera.sample, camera.latency + 2 * camera.burst + 1


def follow_bound(descriptor, hardware, memory, timing, *, camera=None, view=None, addresses=None,
                 progress=lambda fraction: None):
    """:class:`FollowBound` of a frame that begins with the camera's.

    Look-up i enters when its rows are in memory. The time from then to the end of the frame is at
    most that without a camera, where it entered at e(i) or later::

        e(i) = max(i, read(i - pending) + 1)
        end <= max over i of  rows in memory(i) + latency + 1.01 (end without camera - e(i))

    since only earlier look-ups delay a look-up. The hundredth is the error of the predicted clocks.
    A ``camera`` on the same memory port delays each of them too. Its row is in memory after its
    last burst, which may wait for a burst of the corrector.

    Parameters
    ----------
    descriptor : Descriptor
    hardware : Hardware
        With a tile cache of a known size.
    memory : LatencyMemory or DramMemory
    timing : CorrectorTiming
    camera : int or CameraWrites, optional
        Clocks of a row of a camera with its own memory port and a sample per clock, by default
        without blanking; or a camera on the same port.
    view : View, optional
        What the corrected frame shows; the trained picture by default.
    addresses : FrameAddresses, optional
        By default those after reset.
    progress : callable
        Called with the fraction done.
    """
    geometry = descriptor.geometry
    picture = view.geometry(geometry) if view else geometry
    addresses = addresses or FrameAddresses.after_reset(picture, hardware.data_width)
    strip, lanes = hardware.strip, hardware.lanes
    line, row, late = _rows(camera, geometry)
    windows = frame_windows(descriptor, lambda done, total: progress(.5 * done / total), view)
    boxes = lookups(windows, strip, lanes)
    block = getattr(memory, "access_bytes", 1)
    writes = None if hardware.stream else frame_writes(
        picture, hardware, block, addresses.target, timing)
    if isinstance(camera, CameraWrites):
        writes = camera.merged_with(writes, hardware.data_width // 8, block)
    free = predict_clocks(
        misses(accesses(boxes), hardware.cache, hardware.split_for(geometry)), boxes, hardware,
        memory, timing, addresses, writes, lambda done, total: progress(.5 + .5 * done / total))
    free.read.apply_postponed(len(boxes))
    _, y0, used = windows.scanned(strip)
    needed = rows_needed(y0, used, geometry.distorted_height, geometry.interpolation)
    # All pixels of a group wait together.
    needed = needed.reshape(-1, lanes).max(axis=1)
    pending = hardware.cache.pending
    latest, worst, worst_rows = -np.inf, 0, 0
    for piece in pieces(len(boxes)):
        rows = needed[boxes.pixel[piece] // lanes].astype(np.int64)
        number = np.arange(piece.start, piece.stop)
        before = np.maximum(number - pending, 0)
        entered = np.where(number < pending, number,
                           np.maximum(number, free.read.clocks(before) + 1))
        written = np.where(rows, (rows - 1) * float(line) + float(row) + late, 0)
        begin = np.maximum(written + timing.row_to_lookup, timing.start)
        end = begin + (1 + _ERROR) * (free.clocks - timing.start - entered)
        last = int(end.argmax())
        if end[last] > latest:
            latest, worst, worst_rows = end[last], piece.start + last, int(rows[last])
    progress(1)
    camera_clocks = round((geometry.distorted_height - 1) * line + row)
    out = int(np.ceil(latest)) + timing.end_to_interrupt
    return FollowBound(out - camera_clocks, camera_clocks, int(boxes.pixel[worst]), worst_rows)
