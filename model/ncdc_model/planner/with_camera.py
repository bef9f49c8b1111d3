"""Clocks of a frame while a camera writes to the same memory, the next frames or, with early start,
the same one, and while readers take earlier pictures from it."""

from dataclasses import dataclass, replace
from fractions import Fraction
from math import ceil

from ncdc_model.planner.camera_writes import CameraWrites
from ncdc_model.planner.corrector_timing import CorrectorTiming
from ncdc_model.planner.follow import follow_bound
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.reader_reads import SteadyReads, with_reads
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_model.planner.writes import frame_writes
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.frames import FrameAddresses, output_format, target_bytes
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.system_values import stores_for, system_values
from ncdc_spec.sensors.sensor import Timing
from ncdc_spec.view import View

__all__ = ["RunningFrame", "clocks_with_camera", "follow_bound_with_camera"]

_READERS = 2            # of the system: they determine the addresses of its buffers
_QUEUE = 20             # clocks from a sample at the pins to its burst, approximate


@dataclass(frozen=True)
class RunningFrame:
    """A frame in a running system while the camera sends the next ones.

    The frame begins when its raw frame is complete; the next ones go to another buffer. Readers
    have earlier corrected frames. Buffers are at their addresses after a reset.

    Parameters
    ----------
    descriptor : Descriptor
    hardware : Hardware
        With a tile cache, a split and a scan, as :func:`ncdc_model.planner.plan.plan` chooses them.
    memory : LatencyMemory or DramMemory
    timing : CorrectorTiming
    sensor : ncdc_spec.sensors.sensor.Timing
    ratio : Fraction
        Clocks of the corrector per pixel clock of the sensor.
    view : View, optional
        What the corrected frame shows; the trained picture by default.
    rates : sequence of Fraction
        Bytes per clock that each reader of corrected frames in memory takes.
    """
    descriptor: Descriptor
    hardware: Hardware
    memory: object
    timing: CorrectorTiming
    sensor: Timing
    ratio: Fraction
    view: View | None = None
    rates: tuple = ()

    def clocks(self, progress=lambda done, total: None):
        """Clocks of the frame; ``progress(done, total)`` counts misses."""
        hardware, timing = self.hardware, self.timing
        values = system_values(self.descriptor, hardware, stores_for(hardware, _READERS))
        boxes = lookups(frame_windows(self.descriptor, view=self.view), hardware.strip,
                        hardware.lanes)
        missed = misses(accesses(boxes), hardware.cache, hardware.split)
        return predict_clocks(missed, boxes, hardware, self.memory, timing, _addresses(values),
                              self._traffic(values), progress).clocks

    def _traffic(self, values):
        """All accesses to memory but the reads of raw windows, with the addresses ``values``."""
        geometry, hardware = self.descriptor.geometry, self.hardware
        picture = self.view.geometry(geometry) if self.view else geometry
        word, block = hardware.data_width // 8, getattr(self.memory, "access_bytes", 1)
        addresses = _addresses(values)
        writes = None if hardware.stream else frame_writes(picture, hardware, block,
                                                           addresses.target, self.timing)
        camera = CameraWrites.of(self.sensor, self.ratio, geometry, values["RAW1_BASE"],
                                 addresses.pitch, burst=self.timing.write_burst,
                                 latency=_QUEUE - self.timing.start)
        size = target_bytes(picture, hardware.data_width, output_format(hardware.format))
        readers = [SteadyReads(values[f"CORRECTED{1 + k}_BASE"], size, rate)
                   for k, rate in enumerate(self.rates)]
        return with_reads(camera.merged_with(writes, word, block), readers, word, block)


def clocks_with_camera(descriptor, hardware, memory, timing, sensor, ratio):
    """Clocks of a :class:`RunningFrame` without readers; parameters are its."""
    return RunningFrame(descriptor, hardware, memory, timing, sensor, ratio).clocks()


def follow_bound_with_camera(descriptor, hardware, memory, timing, sensor, ratio):
    """:class:`ncdc_model.planner.follow.FollowBound` of a running system that follows its sensor,
    from the last sample of the window at its pins; parameters as of :func:`clocks_with_camera`.

    The corrected frame is released when the raw one has ended without error, which may include the
    blanking of its last row.
    """
    values = system_values(descriptor, hardware, stores_for(hardware, _READERS))
    addresses = _addresses(values)
    camera = CameraWrites.of(sensor, ratio, descriptor.geometry, addresses.source, addresses.pitch,
                             burst=timing.write_burst, latency=_QUEUE)
    bound = follow_bound(descriptor, hardware, memory, timing, addresses=addresses, camera=camera)
    ended = sensor.height * camera.line + camera.latency + 2 * camera.burst - bound.camera_clocks
    return replace(bound, clocks=max(bound.clocks, ceil(ended)))


def _addresses(values):
    """Addresses of a system's first frames after a reset."""
    return FrameAddresses(values["RAW0_BASE"], values.get("CORRECTED0_BASE", 0),
                          values["RAW_PITCH"])
