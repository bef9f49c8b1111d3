"""A camera's frames through a sensor's pins, memory and corrector, each compared."""

from dataclasses import dataclass, field

import numpy as np

from ncdc_hdl.camera.i2c import quarter_clocks
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_model.corrector import correct
from ncdc_model.interface.system_values import memory_bytes
from ncdc_model.sensors.level import levelled
from ncdc_sim.sensor.twin import raw_frames
from ncdc_sim.system.host import SystemHost
from ncdc_sim.system.live import Clocks, LiveSystem
from ncdc_sim.tools import SimulationError

__all__ = ["CameraFrame", "CameraRun", "simulate_camera"]

_COUNTERS = ("LINE_FAULTS", "FRAMES_CUT", "OVERFLOWS", "FRAMES_MISSED", "CLOCK_STOPS", "RAW_BEGUN",
             "RAW_ENDED_BAD", "RAW_TAKEN", "RAW_SKIPPED", "CORRECTED_BEGUN", "CORRECTED_ENDED_BAD",
             "CORRECTED_TAKEN")

_PATIENCE = 1_000_000       # clocks for a frame to come, beside the time of six


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
        Clocks from the beginning of its raw frame until the host knew of it; 0 of a stream.
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
    i2c_errors : list of str
        Flags of `I2C_RESULT` that ended commands.
    clocks : int
        Of the whole run.
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


def simulate_camera(system, setup, light, *, count, corner=(0, 0), follow=False, clocks=None,
                    disturb=None, verilog=None, progress=lambda fraction: None, **run):
    """Let a camera run until ``count`` frames are corrected.

    The sensor is set up by I2C while the camera is enabled already: its first frame is number 1.

    Parameters
    ----------
    system : ncdc_hdl.system.System
    setup : Setup
        Of the sensor; its pixel clock is the one of the run.
    light : Light
    corner : (int, int)
        Column and row of the sensor's frame at which the raw frames begin.
    count : int
    follow : bool
        Whether the corrector follows the camera row by row.
    clocks : Clocks, optional
        Of 100 MHz, and the pixel clock of ``setup``, if absent.
    disturb : callable, optional
        ``disturb(host)`` is called when the first frame has come.
    verilog : str, optional
        The system's text; made if absent.
    progress : callable
        Called with the fraction of the frames that are done.
    run :
        As of :class:`LiveSystem`; with ``fault``, or with ``disturb``, frames may end badly.

    Raises
    ------
    SimulationError
        If a frame does not come in time, or ends badly.
    """
    result, sensor = CameraRun(), setup.sensor
    clocks = clocks or Clocks(extclk_period=2 * round(5e11 / setup.timing.pixel_clock_hz))
    frame = setup.timing.frame_clocks * clocks.extclk_period // clocks.clk_period
    (left, top), (width, height) = corner, system.descriptor.geometry.distorted
    raw = raw_frames(setup, light)[:, top:top + height, left:left + width]
    raw = levelled(raw, sensor.black)
    size = memory_bytes(system.descriptor, system.hardware, system.stores)
    with LiveSystem(verilog or system_verilog(system), sensor.name, light, memory_bytes=size,
                    clocks=clocks, **run) as live:
        host = SystemHost(live, system)
        live.sensor_power(True)
        live.wait(100)
        host.put(SENT_WIDTH=setup.timing.width, SENT_HEIGHT=setup.timing.height,
                 WINDOW_LEFT=left, WINDOW_TOP=top, BLACK_LEVEL=sensor.black,
                 RUN_FOLLOW=int(follow), CLOCK_LIMIT=frame // 2,
                 I2C_QUARTER=quarter_clocks(10**12 // clocks.clk_period, 400_000))
        host.set_up(setup, before_start=lambda: host.put(RUN=1, CAMERA_ENABLE=1))
        host.listen("CORRECTED_FRAME", "CORRECTED_BAD", "RAW_BAD")
        while len(result.frames) < count:
            if not live.wait_irq(6 * frame + _PATIENCE):
                raise SimulationError(f"no frame came in {6 * frame + _PATIENCE} clocks")
            now, events = live.now, host.events()
            if "CORRECTED_FRAME" in events:
                result.frames.append(_frame(host, raw, now))
                progress(len(result.frames) / count)
                if disturb and len(result.frames) == 1:
                    disturb(host)
            elif not disturb and not run.get("fault"):
                raise SimulationError(f"a frame ended badly: {', '.join(sorted(events))}")
        result.counters = {name: host.get(name) for name in _COUNTERS}
        result.i2c_errors = host.i2c_errors
        result.clocks, result.bench = live.now, live.end()
    return result


def _frame(host, raw, now):
    """The newest corrected frame, claimed, compared and released."""
    frame = host.streamed() if host.live.stream else host.claim()
    clocks = host.get("CLOCKS")
    # The sensor's frames, from 1 on: those that the store never saw count too.
    index = frame.number - 1 + host.get("FRAMES_MISSED")
    golden = correct(host.system.descriptor, raw[index % len(raw)],
                     strip=host.system.hardware.strip)
    host.release()
    return CameraFrame(frame.number, host.picture(frame), golden.picture, clocks,
                       frame.time and now - frame.time)
