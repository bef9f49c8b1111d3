"""A camera's frames through a sensor's pins, memory and corrector, each compared."""

from dataclasses import dataclass, field

import numpy as np

from ncdc_model.correction import correct
from ncdc_sim.system.running import running
from ncdc_sim.tools import SimulationError

__all__ = ["CameraFrame", "CameraRun", "corrected_frames", "simulate_camera"]

_COUNTERS = ("LINE_FAULTS", "FRAMES_CUT", "OVERFLOWS", "FRAMES_MISSED", "CLOCK_STOPS", "RAW_BEGUN",
             "RAW_ENDED_BAD", "RAW_TAKEN", "RAW_SKIPPED", "CORRECTED_BEGUN", "CORRECTED_ENDED_BAD",
             "CORRECTED_TAKEN")

_TIMEOUT = 1_000_000       # clocks for a frame to come, plus the time of six


@dataclass(frozen=True)
class CameraFrame:
    """A corrected frame, and the golden model's of its own raw frame.

    Parameters
    ----------
    number : int
        Number of its raw frame, from 1 on.
    picture, golden : ndarray of uint8, shape (height, width, 3)
    clocks : int
        That the corrector took for it.
    age : int
        Clocks from the beginning of its raw frame until the host knew of it; 0 of a stream.
    known : int
        Clock in which the host knew of it.
    bytes_read, bytes_written : int
        Bytes that the memory's ports had moved until then.
    """
    number: int
    picture: np.ndarray
    golden: np.ndarray
    clocks: int
    age: int
    known: int
    bytes_read: int
    bytes_written: int

    @property
    def different(self):
        """Pixels that differ."""
        return int((self.picture != self.golden).any(axis=2).sum())


@dataclass
class CameraRun:
    """Results of a camera's frames.

    Parameters
    ----------
    frames : list of CameraFrame
    counters : dict
        Registers of the camera and the stores that count, by name; with those of a CSI-2 receiver.
    bench : dict
        Counters of the bench.
    i2c_errors : list of str
        Flags of `I2C_RESULT` that ended commands.
    clocks : int
        Clocks of the whole run.
    """
    frames: list = field(default_factory=list)
    counters: dict = field(default_factory=dict)
    bench: dict = field(default_factory=dict)
    i2c_errors: list = field(default_factory=list)
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


def simulate_camera(system, setup, light, *, count, follow=False, disturb=None,
                    progress=lambda fraction: None, **run):
    """Let a camera run until ``count`` frames are corrected.

    Parameters
    ----------
    system, setup, light :
        As of :func:`running`.
    count : int
    follow : bool
        Early start: whether the corrector follows the camera row by row.
    disturb : callable, optional
        ``disturb(host)`` is called when the first frame has come.
    progress : callable
        Called with the fraction of the frames that are done.
    run :
        As of :func:`running`; with ``fault``, or with ``disturb``, frames may end badly.

    Raises
    ------
    SimulationError
        If a frame does not come in time, or ends badly.
    """
    with running(system, setup, light, registers={"RUN_FOLLOW": int(follow)}, **run) as camera:
        return corrected_frames(camera, count, faulty=bool(run.get("fault")), disturb=disturb,
                                progress=progress)


def corrected_frames(camera, count, *, faulty=False, disturb=None,
                     progress=lambda fraction: None):
    """The :class:`CameraRun` of a :class:`~ncdc_sim.system.running.Running` camera until ``count``
    frames are corrected, which ends its simulation.

    Parameters
    ----------
    camera : Running
    count : int
    faulty : bool
        Whether frames may end badly.
    disturb, progress :
        As of :func:`simulate_camera`.

    Raises
    ------
    SimulationError
        If a frame does not come in time, or ends badly.
    """
    result, host, live = CameraRun(), camera.host, camera.host.live
    limit = 6 * camera.frame_clocks + _TIMEOUT
    host.camera.listen("CORRECTED_FRAME", "CORRECTED_BAD", "RAW_BAD")
    while len(result.frames) < count:
        if not live.wait_irq(limit):
            raise SimulationError(f"no frame came in {limit} clocks")
        now, moved, events = live.now, live.counters(), host.camera.events()
        if "CORRECTED_FRAME" in events:
            result.frames.append(_frame(camera, now, moved))
            progress(len(result.frames) / count)
            if disturb and len(result.frames) == 1:
                disturb(host)
        elif not disturb and not faulty:
            counts = ", ".join(f"{name} {value}" for name, value in _counters(host).items())
            raise SimulationError(f"a frame ended badly: {', '.join(sorted(events))}; {counts}")
    result.counters = _counters(host)
    result.i2c_errors = host.camera.i2c_errors
    result.clocks, result.bench = live.now, live.end()
    return result


def _counters(host):
    """Registers of the camera and the stores that count, by name."""
    faults = host.system.camera.fault_registers.values()
    return {name: host.get(name) for name in (*_COUNTERS, *faults)}


def _frame(camera, now, moved):
    """The newest corrected frame, claimed, compared and released; ``moved``: counters of the bench
    when the host knew of it."""
    host = camera.host
    frame = host.streamed() if host.live.stream else host.claim()
    clocks = host.get("CLOCKS")
    golden = correct(host.system.descriptor, camera.sent(frame.number),
                     strip=host.system.hardware.strip)
    host.camera.release(0)
    beats = sum(moved[f"read{k}_beats"] for k in range(host.live.readers))
    return CameraFrame(frame.number, host.picture(frame), golden.picture, clocks,
                       frame.time and now - frame.time, now, beats * host.live.width // 8,
                       moved["write_bytes"])
