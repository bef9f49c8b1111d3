"""A camera of 3840x2160 at 60 frames per second: every frame is corrected as it comes."""

from dataclasses import dataclass
from fractions import Fraction

import numpy as np

from ncdc_bench.throughput.lenses import Lens, trained
from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_hdl.system import System
from ncdc_model.planner.memory_timing import memory_at
from ncdc_model.planner.plan import Fixed, plan
from ncdc_model.planner.with_camera import clocks_with_camera
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.camera import corrected_frames
from ncdc_sim.system.video import video_running
from ncdc_spec.camera_port import AXIS, CameraPort
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DEFAULT, GRADIENT
from ncdc_spec.sensors.sensor import Timing

__all__ = ["FRAMES_PER_SECOND", "RUNS", "UHD", "Run", "failures", "measure"]

FRAMES_PER_SECOND = 60
UHD = Timing(3840, 2160, 3856, 2161, 500_000_000)
"""3840x2160 at 60 frames per second in beats of four samples at 125 MHz. Capture takes four samples
per clock of the core, so that blanking is short: rows of a faster clock would fill its queue."""

_CLOCK_MHZ = 125
_DEGREES, _NEURONS = 120, 16
_LANES, _DATA_WIDTH = 4, 128
# 16 rows of 3840 samples or more: fewer evict tiles that are still needed. Four pixels per clock
# hide the latency of the memory with more look-ups and tiles under way than one pixel does.
_CACHE = Fixed(131072, pending=256, outstanding=64)
_PREDICTION = .01       # of the clocks, by which the planner may be wrong


@dataclass(frozen=True)
class Run:
    """A camera to be run, and the hardware that corrects its frames.

    Parameters
    ----------
    interpolation, memory : str
        The memory's timing is that of :data:`_CLOCK_MHZ`.
    timing : Timing
        Size and rate of the camera's frames, four samples per clock.
    frames : int
    cache : Fixed
        What of the tile cache is given.
    """
    interpolation: str = GRADIENT.name
    memory: str = "ddr3"
    timing: Timing = UHD
    frames: int = 2
    cache: Fixed = _CACHE

    @property
    def size(self):
        """Width and height of raw and corrected frames."""
        return self.timing.width, self.timing.height

    @property
    def descriptor(self):
        """The descriptor of its lens, trained once."""
        return trained(Lens(_DEGREES, self.size, nodes="auto", interpolation=self.interpolation,
                            neurons=_NEURONS))

    def __str__(self):
        return (f"{self.frames} frames of {self.size[0]}x{self.size[1]} at "
                f"{self.timing.frames_per_second:g} per second on {self.memory}, "
                f"{self.interpolation}")


RUNS = [Run(interpolation.name) for interpolation in (GRADIENT, DEFAULT)]


def measure(runs, progress=lambda run: None):
    """A row for each of ``runs``; rows come one by one.

    Yields
    ------
    dict
        ``width``, ``height``, ``lens`` (degrees of its view), ``interpolation``,
        ``hidden_neurons``, ``nodes``, ``pixels_per_clock``, ``samples_per_clock``, ``output``,
        ``memory``, ``data_width``, ``clock_mhz``, ``cache_bytes``, ``cache_split``,
        ``cache_pending``, ``cache_outstanding``, ``frames``, ``pixels_compared``,
        ``pixels_different``. ``clocks``: of the slowest frame; ``predicted_clocks``: the
        planner's, with the camera's own writes; ``clocks_per_pixel`` and
        ``predicted_clocks_per_pixel``. ``frames_per_second``: at ``clock_mhz``, by the slowest
        frame; ``camera_frames_per_second``.
        ``frames_skipped``: good frames of the camera that were not corrected. ``frames_lost``:
        that capture dropped, or that ended as bad. ``bytes_read``, ``bytes_written``: on the
        memory's ports from one corrected frame to the next, a mean; ``bytes_read_expected``: for
        a frame, by the planner. ``amplification``: bytes read over distinct bytes;
        ``memory_load``: bytes moved over those that the memory could move meanwhile.
    """
    verilogs = {}
    for run in runs:
        yield _row(run, verilogs, progress(run))


def _row(run, verilogs, show):
    descriptor = run.descriptor
    hardware = Hardware(data_width=_DATA_WIDTH, output="stream", lanes=_LANES)
    planned = plan(descriptor, hardware, run.memory,
                   lambda chosen: Corrector(descriptor, chosen).timing,
                   fixed=run.cache, clock_mhz=_CLOCK_MHZ)
    system = System(descriptor, planned.hardware, camera=CameraPort(AXIS, samples=_LANES))
    key = descriptor.digest, system.hardware
    if key not in verilogs:
        verilogs[key] = system_verilog(system)
    memory = memory_at(run.memory, _CLOCK_MHZ)
    predicted = clocks_with_camera(descriptor, planned.hardware, memory, system.corrector.timing,
                                   run.timing,
                                   Fraction(_CLOCK_MHZ * 10**6, run.timing.pixel_clock_hz))
    width, height = run.size
    light = Light(np.random.default_rng(1).integers(0, 4096, (2, height, width), np.uint16))
    with video_running(system, run.timing, light, clock_hz=_CLOCK_MHZ * 10**6,
                       verilog=verilogs[key], memory=memory) as camera:
        result = corrected_frames(camera, run.frames, progress=show)
    return {"width": width, "height": height, "lens": _DEGREES,
            "interpolation": run.interpolation, "hidden_neurons": descriptor.hidden_neurons,
            "nodes": descriptor.nodes, "pixels_per_clock": hardware.lanes,
            "samples_per_clock": system.camera.samples, "output": hardware.output,
            "memory": run.memory, "data_width": hardware.data_width, "clock_mhz": _CLOCK_MHZ,
            "cache_bytes": planned.hardware.cache.bytes,
            "cache_split": planned.hardware.split,
            "cache_pending": planned.hardware.cache.pending,
            "cache_outstanding": planned.hardware.cache.outstanding, "predicted_clocks": predicted,
            "predicted_clocks_per_pixel": predicted / planned.pixels,
            **_figures(run, planned, memory, result)}


def _figures(run, planned, memory, result):
    """Measured figures of a row."""
    report = result.report()
    clocks = max(frame.clocks for frame in result.frames)
    first, last = result.frames[0], result.frames[-1]
    between = len(result.frames) - 1
    read = (last.bytes_read - first.bytes_read) / between
    written = (last.bytes_written - first.bytes_written) / between
    word_clocks = memory.word_clocks / memory.ratio     # of the corrector
    moved = memory.word_bytes * (last.known - first.known) / between / word_clocks
    return {"frames": report["frames"], "pixels_compared": report["pixels_compared"],
            "pixels_different": report["pixels_different"], "clocks": clocks,
            "clocks_per_pixel": report["clocks_per_pixel"],
            "frames_per_second": _CLOCK_MHZ * 1e6 / clocks,
            "camera_frames_per_second": run.timing.frames_per_second,
            "frames_skipped": report["raw_skipped"],
            "frames_lost": sum(report[name] for name in (
                "overflows", "frames_missed", "raw_ended_bad", "corrected_ended_bad")),
            "bytes_read": read,
            "bytes_read_expected": planned.misses * planned.hardware.cache.tile_bytes,
            "bytes_written": written, "amplification": read / planned.distinct,
            "memory_load": float((read + written) / moved)}


def failures(rows):
    """Sentences on what went wrong in ``rows``."""
    found = []
    for row in rows:
        name = f"{row['interpolation']} on {row['memory']}, {row['cache_bytes']} bytes of cache"
        if row["pixels_different"]:
            found.append(f"{name}: {row['pixels_different']} pixels differ")
        if row["frames_lost"]:
            found.append(f"{name}: {row['frames_lost']} frames were lost")
        if row["frames_skipped"]:
            found.append(f"{name}: {row['frames_skipped']} frames of the camera were skipped")
        if row["bytes_read"] != row["bytes_read_expected"]:
            found.append(f"{name}: {row['bytes_read']:.0f} bytes were read for a frame, "
                         f"{row['bytes_read_expected']} are expected")
        if row["frames_per_second"] < FRAMES_PER_SECOND:
            found.append(f"{name}: {row['frames_per_second']:.2f} frames per second, at least "
                         f"{FRAMES_PER_SECOND} are asked for")
        if abs(row["clocks"] / row["predicted_clocks"] - 1) > _PREDICTION:
            found.append(f"{name}: {row['predicted_clocks']} clocks of a frame were predicted, "
                         f"{row['clocks']} are measured")
    return found
