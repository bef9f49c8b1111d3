"""A camera's frames through a sensor's pins, memory and corrector, each compared."""

from dataclasses import dataclass, field

import numpy as np

from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_model.corrector import correct
from ncdc_model.interface.system_values import memory_bytes
from ncdc_sim.system.host import SystemHost
from ncdc_sim.system.live import LiveSystem
from ncdc_sim.tools import SimulationError

__all__ = ["CameraFrame", "CameraRun", "simulate_camera"]

_COUNTERS = ("LINE_FAULTS", "FRAMES_CUT", "OVERFLOWS", "FRAMES_MISSED", "CLOCK_STOPS", "RAW_BEGUN",
             "RAW_ENDED_BAD", "RAW_TAKEN", "RAW_SKIPPED", "CORRECTED_BEGUN", "CORRECTED_ENDED_BAD",
             "CORRECTED_TAKEN")


@dataclass(frozen=True)
class CameraFrame:
    """A corrected frame, beside the golden model's of its own raw frame.

    Parameters
    ----------
    number : int
        Of its raw frame, from 1 on.
    picture, golden : ndarray of uint8, shape (height, width, 3)
    clocks : int
        That the corrector took for it.
    age : int
        Clocks from the beginning of its raw frame until the host knew of it.
    """
    number: int
    picture: np.ndarray
    golden: np.ndarray
    clocks: int
    age: int

    @property
    def different(self):
        """Pixels that differ."""
        return int((self.picture != self.golden).any(axis=2).sum())


@dataclass
class CameraRun:
    """What became of a camera's frames.

    Parameters
    ----------
    frames : list of CameraFrame
    counters : dict
        Registers of the camera and the stores that count, by name.
    bench : dict
        Counters of the bench.
    clocks : int
        Of the whole run.
    """
    frames: list = field(default_factory=list)
    counters: dict = field(default_factory=dict)
    bench: dict = field(default_factory=dict)
    clocks: int = 0

    def report(self):
        """The figures under their names in every report."""
        pixels = [frame.golden.shape[0] * frame.golden.shape[1] for frame in self.frames]
        return {
            "frames": len(self.frames), "pixels_compared": sum(pixels),
            "pixels_different": sum(frame.different for frame in self.frames),
            "clocks_per_pixel": max((frame.clocks / count
                                     for frame, count in zip(self.frames, pixels)), default=None),
            **{name.lower(): value for name, value in self.counters.items()},
            "clocks": self.clocks,
        }


def simulate_camera(system, sensor, golden, start, *, count, follow=False, black=0,
                    progress=lambda fraction: None, frame_limit=20_000_000, **run):
    """Let a camera run until ``count`` frames are corrected.

    Parameters
    ----------
    system : ncdc_hdl.system.System
    sensor : Sensor
    golden : callable
        The bytes of the raw frame, by its number from 1 on.
    start : callable
        ``start(host)`` sets the sensor up, by I2C, and lets it send. The camera is enabled before.
    count : int
    follow : bool
        Whether the corrector follows the camera row by row.
    black : int
        Taken off each sample.
    progress : callable
        Called with the fraction of the frames that are done.
    frame_limit : int
        Clocks within which a frame must come.
    run :
        As of :class:`LiveSystem`.

    Raises
    ------
    SimulationError
        If a frame does not come in time.
    """
    result = CameraRun()
    descriptor = system.descriptor
    size = memory_bytes(descriptor, system.hardware, system.stores)
    with LiveSystem(system_verilog(system), sensor, memory_bytes=size, **run) as live:
        host = SystemHost(live, system)
        live.sensor_power(True)
        live.wait(100)
        host.put(BLACK_LEVEL=black, RUN_FOLLOW=int(follow), RUN=1, CAMERA_ENABLE=1)
        host.listen("CORRECTED_FRAME", "CORRECTED_BAD", "RAW_BAD")
        start(host)
        while len(result.frames) < count:
            if not live.wait_irq(frame_limit):
                raise SimulationError(f"no frame came in {frame_limit} clocks")
            events, now = host.events(), live.now
            if "CORRECTED_FRAME" not in events:
                raise SimulationError(f"a frame ended badly: {', '.join(sorted(events))}")
            frame = host.claim()
            result.frames.append(CameraFrame(
                frame.number, host.picture(frame),
                correct(descriptor, golden(frame.number), strip=system.hardware.strip).picture,
                host.get("CLOCKS"), now - frame.time))
            host.release()
            progress(len(result.frames) / count)
        result.counters = {name: host.get(name) for name in _COUNTERS}
        result.clocks, result.bench = live.now, live.end()
    return result
