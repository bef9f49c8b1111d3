"""The whole system with a camera's stream of video, from its beats to corrected pictures."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.export.verilog.system_cover import system_verilog
from ncdc_hdl.system import System
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.camera import simulate_camera
from ncdc_spec.camera_port import AXIS, camera_port
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings
from simulations.video import from_pins

pytestmark = pytest.mark.longer

SIZE = WIDTH, HEIGHT = 64, 24


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
