"""The whole camera system with AXI ports: sensor's pins to corrected pictures."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.axi.top import AxiTop
from ncdc_hdl.export.verilog.axi_cover import axi_verilog
from ncdc_hdl.system import System
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.camera import simulate_camera
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings
from simulations.axi import adapted

WIDTH, HEIGHT = 64, 24


@pytest.mark.regress
@pytest.mark.parametrize("follow", [False, True])
@pytest.mark.parametrize("output", ["memory", "stream"])
def test_every_frame_is_its_own_raw_frame_corrected(output, follow):
    """Camera and corrector share the write port, whose answers come late and at random."""
    d = barrel_descriptor((WIDTH, HEIGHT), (WIDTH, HEIGHT), hidden_neurons=2, strength=.4)
    system = System(d, Hardware(data_width=64, output=output, bus="axi"))
    verilog = adapted(axi_verilog(AxiTop(system)), core="ncdc_system_axi", top="ncdc_system",
                      lines=HEIGHT)
    sensor = sensor_named("mt9p031")
    asked = setup(sensor, Settings(width=WIDTH, height=HEIGHT, exposure_us=100,
                                   clock_hz=sensor.pixel_clock_hz))
    light = Light(np.random.default_rng(1).integers(0, 4096, (6, HEIGHT, WIDTH), dtype=np.uint16))
    run = simulate_camera(system, asked, light, count=3, verilog=verilog, follow=follow,
                          more=("+axi_wait=60", "+axi_answer=60"))
    assert [frame.different for frame in run.frames] == [0, 0, 0]
    assert not any(run.counters[name] for name in ("OVERFLOWS", "RAW_ENDED_BAD",
                                                   "CORRECTED_ENDED_BAD"))
    assert not any(value for name, value in run.bench.items() if name.endswith("_errors"))
