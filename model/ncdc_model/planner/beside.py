"""How fast a frame is corrected while a camera writes to the same memory, the next frames or, if it
is followed, this one."""

from dataclasses import replace
from math import ceil

from ncdc_model.planner.camera_writes import CameraWrites
from ncdc_model.planner.follow import follow_bound
from ncdc_model.planner.lookups import frame_windows, lookups
from ncdc_model.planner.tags import accesses, misses
from ncdc_model.planner.timing import predict_clocks
from ncdc_model.planner.writes import frame_writes
from ncdc_spec.frames import FramePlaces
from ncdc_spec.registers.system_values import stores_for, system_values

__all__ = ["clocks_beside_camera", "follow_bound_beside_camera"]

_READERS = 2            # of the system: they say where its buffers lie
_QUEUE = 20             # clocks from a sample at the pins to the burst that it completes, about


def clocks_beside_camera(descriptor, hardware, memory, timing, sensor, ratio):
    """Clocks of a frame of a running system, in which the camera goes on.

    The frame begins when its raw frame is complete; the next ones come meanwhile, into another
    buffer. Buffers lie where they do after a reset.

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
    """
    geometry, word = descriptor.geometry, hardware.data_width // 8
    values = system_values(descriptor, hardware, stores_for(hardware, _READERS))
    places = _places(values)
    block = getattr(memory, "access_bytes", 1)
    boxes = lookups(frame_windows(descriptor), hardware.strip, hardware.lanes)
    missed = misses(accesses(boxes), hardware.cache, hardware.split)
    writes = None if hardware.stream else frame_writes(geometry, hardware, block, places.target,
                                                       timing)
    camera = CameraWrites.of(sensor, ratio, geometry, values["RAW1_BASE"], places.pitch,
                             burst=timing.write_burst, latency=_QUEUE - timing.start)
    return predict_clocks(missed, boxes, hardware, memory, timing, places,
                          camera.beside(writes, word, block)).clocks


def follow_bound_beside_camera(descriptor, hardware, memory, timing, sensor, ratio):
    """:class:`ncdc_model.planner.follow.FollowBound` of a running system that follows its sensor,
    from the last sample of the window at its pins; parameters as of :func:`clocks_beside_camera`.

    The corrected frame is handed on when the raw one has ended well, whose last row's blanking may
    be part of it.
    """
    values = system_values(descriptor, hardware, stores_for(hardware, _READERS))
    places = _places(values)
    camera = CameraWrites.of(sensor, ratio, descriptor.geometry, places.source, places.pitch,
                             burst=timing.write_burst, latency=_QUEUE)
    bound = follow_bound(descriptor, hardware, memory, timing, places=places, camera=camera)
    ended = sensor.height * camera.line + camera.latency + 2 * camera.burst - bound.camera_clocks
    return replace(bound, clocks=max(bound.clocks, ceil(ended)))


def _places(values):
    """Where a system's first frames lie after a reset."""
    return FramePlaces(values["RAW0_BASE"], values.get("CORRECTED0_BASE", 0), values["RAW_PITCH"])
