"""The whole system with a camera's stream of video, from its beats to corrected pictures."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_hdl.system import System
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.camera import corrected_frames, simulate_camera
from ncdc_sim.system.corrector import tiles_fetched
from ncdc_sim.system.video import video_running
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.camera_port import AXIS, CameraPort, camera_port
from ncdc_spec.errors import InputError
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import GRADIENT
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings, Timing
from simulations.video import from_pins

SIZE = WIDTH, HEIGHT = 64, 24


@pytest.mark.longer
@pytest.mark.parametrize("camera", [
    ("avalon-st:vip", 4, 16), *(pytest.param(camera, marks=pytest.mark.regress)
                                for camera in (("axis", 2, 12), ("avalon-st", 1, 12)))])
def test_every_frame_is_its_own_raw_frame_corrected(camera):
    camera = camera_port(*camera)
    system = System(barrel_descriptor(SIZE, SIZE, hidden_neurons=2, strength=.4),
                    Hardware(data_width=64), camera=camera)
    sensor = sensor_named("mt9p031")
    asked = setup(sensor, Settings(width=WIDTH, height=HEIGHT, exposure_us=100,
                                   clock_hz=sensor.pixel_clock_hz))
    light = Light(np.random.default_rng(1).integers(0, 4096, (6, HEIGHT, WIDTH), dtype=np.uint16))
    faults = {}

    def disturb(host):
        """Look at the counters of the source's faults after the first frame."""
        faults.update({name: host.get(name) for name in (
            "SOURCE_FAULTS", *camera.fault_registers.values())})

    run = simulate_camera(system, asked, light, count=3, disturb=disturb,
                          verilog=from_pins(system_verilog(system), camera, SIZE))
    assert [(frame.number, frame.different) for frame in run.frames] == [(1, 0), (2, 0), (3, 0)]
    # Until it is set up the sensor sends other frames, whose rows after the last one are stray.
    assert faults.pop("VIDEO_STRAY") > 0 or camera.kind != AXIS
    assert not any(faults.values()) and len(faults) == len(camera.faults)
    assert not any(run.counters[name] for name in (
        "LINE_FAULTS", "FRAMES_CUT", "OVERFLOWS", "FRAMES_MISSED", "RAW_ENDED_BAD",
        "CORRECTED_ENDED_BAD"))
    assert not any(value for name, value in run.bench.items() if name.endswith("_errors"))


def video_system(size):
    """Four samples and four pixels per clock, from nodes to a stream."""
    descriptor = barrel_descriptor(size, size, hidden_neurons=2, strength=.4,
                                   interpolation=GRADIENT)
    hardware = Hardware(data_width=128, output="stream", lanes=4, cache=CacheOptions(
        64, pending=64, outstanding=16, interpolation=GRADIENT))
    return System(replace(descriptor, nodes=16), hardware, camera=CameraPort(AXIS, samples=4))


@pytest.mark.longer
def test_no_frame_of_four_samples_per_clock_is_skipped():
    """As many frames come as are corrected, without a pause that the camera did not make."""
    size = width, height = 160, 48
    system, timing = video_system(size), Timing(width, height, width + 80, height + 4, 594_000_000)
    light = Light(np.random.default_rng(1).integers(0, 4096, (3, height, width), np.uint16))
    with video_running(system, timing, light, clock_hz=125_000_000, memory="ddr3@125") as camera:
        run = corrected_frames(camera, 4)
    assert [(frame.number, frame.different) for frame in run.frames] == [
        (1, 0), (2, 0), (3, 0), (4, 0)]
    assert not any(value for name, value in run.counters.items() if not name.endswith("_BEGUN"))
    assert not any(value for name, value in run.bench.items() if name.endswith("_errors"))
    first, last = run.frames[0], run.frames[-1]
    assert (last.known - first.known) / 3 == pytest.approx(camera.frame_clocks, rel=.02)
    assert max(frame.clocks for frame in run.frames) < camera.frame_clocks
    tile = system.hardware.cache.tile_bytes
    assert last.bytes_read == 4 * tile * tiles_fetched(system.descriptor, system.hardware)
    # The camera goes on while a frame is corrected.
    assert last.bytes_written - first.bytes_written == 3 * width * height


@pytest.mark.parametrize("change,message", [
    ({"width": 158}, "width of the video is 158, it must be a multiple of the 4 samples"),
    ({"line_clocks": 202}, "line_clocks of the video is 202, it must be a multiple")])
def test_video_has_whole_beats(change, message):
    timing = replace(Timing(160, 32, 200, 36, 594_000_000), **change)
    with pytest.raises(InputError, match=message), \
            video_running(video_system((160, 32)), timing, None, clock_hz=125_000_000):
        pass
