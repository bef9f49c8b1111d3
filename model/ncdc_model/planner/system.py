"""A whole system on one memory: camera, corrector, and a screen or a network."""

from dataclasses import dataclass
from fractions import Fraction

from ncdc_model.planner.memory_timing import DramMemory
from ncdc_model.planner.with_camera import RunningFrame
from ncdc_spec.errors import InputError
from ncdc_spec.frames import frame_bytes, output_format
from ncdc_spec.sensors.sensor import Timing

__all__ = ["Readers", "SystemPlan", "capacity", "steady_camera", "system_plan", "taken",
           "traffic"]

_CAMERA, _CORRECTOR, _MEMORY, _NETWORK = "camera", "corrector", "memory", "network"
_SCREEN = "screen"
_WAITS = 1.02           # clocks of a frame over those without other traffic: memory is the limit

_RATE_DENOMINATOR = 1 << 16     # of a reader's bytes per clock
_MIN_HZ = 1000                  # of a steady camera's pixel clock, a whole number of Hz


@dataclass(frozen=True)
class Readers:
    """Who takes the corrected pictures.

    Parameters
    ----------
    screen_fps : float, optional
        Frames per second of a screen, which shows a picture again until the next one is there.
    network_mbps : float, optional
        Megabits of pixels per second that a network takes; it sends each picture once.

    Raises
    ------
    InputError
        If a rate is not positive.
    """
    screen_fps: float | None = None
    network_mbps: float | None = None

    def __post_init__(self):
        for name, value, unit in (("screen", self.screen_fps, "frames per second"),
                                  ("network", self.network_mbps, "Mb/s")):
            if value is not None and not 0 < value < float("inf"):
                raise InputError(f"the {name}'s rate is {value:g} {unit}, it must be positive")

    def limits(self, picture_bytes, stream):
        """Pictures of so many bytes per second that each reader takes at most, by name.

        A screen that reads memory shows a picture as often as it likes; one on a ``stream`` takes
        each picture once.
        """
        found = {_NETWORK: None if self.network_mbps is None
                 else self.network_mbps * 1e6 / 8 / picture_bytes,
                 _SCREEN: self.screen_fps if stream else None}
        return {name: rate for name, rate in found.items() if rate is not None}

    def rates(self, picture_bytes, camera_fps):
        """Bytes per second, by name, that are read from memory, at most."""
        rates = {} if self.screen_fps is None else {_SCREEN: self.screen_fps}
        rates |= {name: min(rate, camera_fps)
                  for name, rate in self.limits(picture_bytes, False).items()}
        return {name: rate * picture_bytes for name, rate in rates.items()}


@dataclass(frozen=True)
class SystemPlan:
    """Predicted rates of a running system.

    Parameters
    ----------
    camera_fps, corrector_fps : float
        Frames per second that the camera sends, and that are corrected at most.
    reader_fps : dict of str to float
        Pictures per second that readers take at most, by name.
    clocks : int
        Of a frame, with all other traffic.
    waits : bool
        Whether a frame takes clearly longer with memory than with one that never waits.
    parts : dict of str to float
        Bytes per second of each part.
    capacity : float or None
        Bytes per second that the memory moves without a pause; None: no limit.
    """
    camera_fps: float
    corrector_fps: float
    reader_fps: dict
    clocks: int
    waits: bool
    parts: dict
    capacity: float | None

    @property
    def limits(self):
        """Frames per second that each part allows, by name."""
        return {_CAMERA: self.camera_fps,
                _MEMORY if self.waits else _CORRECTOR: self.corrector_fps, **self.reader_fps}

    @property
    def limited_by(self):
        """The part that limits the frame rate."""
        return min(self.limits, key=self.limits.get)

    @property
    def frames_per_second(self):
        """Corrected frames per second."""
        return min(self.limits.values())

    def report(self):
        """The figures under their names in every report."""
        return {"frames_per_second": self.frames_per_second, "limited_by": self.limited_by,
                "limits_per_second": self.limits,
                "memory_mb_per_second": None if self.capacity is None else self.capacity / 1e6,
                "parts": traffic(self.parts, self.capacity)}


def traffic(parts, moved):
    """Rows of a report: ``part``, ``mb_per_second`` and ``share`` of what the memory moves.

    Parameters
    ----------
    parts : dict of str to float
        Bytes per second, by part.
    moved : float or None
        Bytes per second that the memory moves; None: no limit, no share.
    """
    return [{"part": name, "mb_per_second": rate / 1e6,
             "share": None if moved is None else rate / moved} for name, rate in parts.items()]


def capacity(memory, clock_mhz):
    """Bytes per second that a memory moves without a pause; None: no limit.

    Parameters
    ----------
    memory : LatencyMemory or DramMemory
    clock_mhz : float
        The corrector's clock.
    """
    if isinstance(memory, DramMemory):
        return float(memory.word_bytes / (memory.word_clocks * memory.period) * 10**9)
    rate = memory.bytes_per_clock
    return None if rate is None else rate * clock_mhz * 1e6


def steady_camera(geometry, frames_per_second):
    """:class:`Timing` of a camera without blanking, of so many raw frames per second.

    Raises
    ------
    InputError
        If the rate is not positive or not finite, or gives less than 1000 samples per second.
    """
    width, height = geometry.distorted
    hz = width * height * frames_per_second
    if not 0 < hz < float("inf"):
        raise InputError(f"the camera's rate is {frames_per_second:g} frames per second, it must "
                         "be positive")
    if hz < _MIN_HZ:
        raise InputError(f"the camera's rate is {frames_per_second:g} frames per second, with "
                         f"{width}x{height} samples the least is {_MIN_HZ / width / height:.3g}")
    return Timing(width, height, line_clocks=width, frame_lines=height, pixel_clock_hz=round(hz))


def taken(geometry, hardware, memory, name, clock_mhz, camera, readers):
    """Bytes per second of camera and readers, by part, at most, and those that the memory moves.

    Parameters
    ----------
    geometry : Geometry
        Of the corrected and of the raw frames.
    hardware : Hardware
    memory : LatencyMemory or DramMemory
    name : str
        Its name.
    clock_mhz : float
        The corrector's clock.
    camera : ncdc_spec.sensors.sensor.Timing
    readers : Readers

    Raises
    ------
    InputError
        If the memory, or the port of one of them, does not move as many.
    """
    width, height = geometry.distorted
    found = {_CAMERA: width * height * camera.frames_per_second}
    if not hardware.stream:
        found |= readers.rates(frame_bytes(geometry, output_format(hardware.format)),
                               camera.frames_per_second)
    there = capacity(memory, clock_mhz)
    if there is not None and sum(found.values()) >= there:
        raise InputError(f"the traffic of {' and '.join(found)} is "
                         f"{sum(found.values()) / 1e6:.0f} MB/s, the memory {name} moves "
                         f"{there / 1e6:.0f} MB/s at most")
    port = hardware.data_width / 8 * clock_mhz * 1e6        # a word per clock
    for part, rate in found.items():
        if rate >= port:
            raise InputError(f"the traffic of the {part} is {rate / 1e6:.0f} MB/s, a port of "
                             f"{hardware.data_width} bits moves {port / 1e6:.0f} MB/s at most")
    return found, there


def system_plan(descriptor, planned, memory, timing, camera, readers=Readers(), view=None,
                progress=lambda done, total: None):
    """:class:`SystemPlan` of a corrector as planned, with a camera and readers.

    Parameters
    ----------
    descriptor : Descriptor
    planned : Plan
        Of the frames, on the same memory without other traffic.
    memory : LatencyMemory or DramMemory
    timing : CorrectorTiming
    camera : ncdc_spec.sensors.sensor.Timing
    readers : Readers
        Of pictures in memory, or of the stream.
    view : View, optional
        What the corrected frame shows; the trained picture by default.
    progress : callable
        Called with (misses done, misses).

    Raises
    ------
    InputError
        If camera and readers alone need more than the memory or their ports move.
    """
    hardware, hz = planned.hardware, planned.clock_mhz * 1e6
    geometry = view.geometry(descriptor.geometry) if view else descriptor.geometry
    picture = frame_bytes(geometry, output_format(hardware.format))
    reads, there = taken(geometry, hardware, memory, planned.memory, planned.clock_mhz, camera,
                         readers)
    writes, sends = reads.pop(_CAMERA), camera.frames_per_second
    rates = [Fraction(rate / hz).limit_denominator(_RATE_DENOMINATOR) for rate in reads.values()]
    clocks = RunningFrame(descriptor, hardware, memory, timing, camera,
                          Fraction(hz) / camera.pixel_clock_hz, view,
                          tuple(filter(None, rates))).clocks(progress)
    limits = readers.limits(picture, hardware.stream)
    rate = min(sends, hz / clocks, *limits.values())
    if _NETWORK in reads:
        reads[_NETWORK] = rate * picture
    parts = {"camera, writes": writes,
             "corrector, reads": planned.misses * hardware.cache.tile_bytes * rate}
    if not hardware.stream:
        parts["corrector, writes"] = picture * rate
    parts |= {f"{name}, reads": each for name, each in reads.items()}
    return SystemPlan(sends, hz / clocks, limits, clocks,
                      clocks > _WAITS * planned.unhindered, parts, there)
