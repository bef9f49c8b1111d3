"""A system with a CSI-2 sensor: from its lanes to pictures that equal the golden model's."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.system import System
from ncdc_sim.sensor.photo import moving_photo
from ncdc_sim.sensor.verilog import Fault
from ncdc_sim.system.camera import simulate_camera
from ncdc_spec.camera_port import CSI2, CameraPort
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.framing import grid_row, setup_around

SIZE = (64, 24)


def run(name, size, count, *, hidden_neurons=2, field=None, more=(), **options):
    """Frames in motion: registers by I2C, lanes, receiver, memory and corrector, in Verilog."""
    descriptor = barrel_descriptor(size, size, hidden_neurons=hidden_neurons, strength=.4)
    plan, crop = setup_around(name, descriptor.geometry, field=field, exposure_us=200)
    assert crop.grid == (field is not None)
    photo = np.random.default_rng(1).integers(0, 256, (*size[::-1], 3), np.uint8)
    light = moving_photo(descriptor, plan, crop, photo, count, (5, 0))
    system = System(descriptor, Hardware(data_width=64), grid=grid_row(plan, crop),
                    camera=CameraPort(CSI2, 2, serial=crop.grid))
    return simulate_camera(system, plan, light, corner=crop, count=count, more=more, **options)


def check(result, count):
    """All of the golden model's, and as many different ones."""
    assert [frame.different for frame in result.frames] == [0] * count
    assert len({frame.picture.tobytes() for frame in result.frames}) == count


@pytest.mark.longer
@pytest.mark.parametrize("name", ["imx219", pytest.param("ov5647", marks=pytest.mark.regress)])
def test_pictures_of_a_csi2_sensor(name):
    check(run(name, SIZE, 3), 3)


@pytest.mark.regress
@pytest.mark.parametrize("name,field", [
    ("imx219", "256x96"), ("imx219", "128x48"), ("ov5647", "256x96")])
def test_pictures_of_a_reduced_field(name, field):
    """Binned by the sensor, one sample per clock, the grid stage, which bins 256x96 once more."""
    check(run(name, SIZE, 3, field=field), 3)


@pytest.mark.longer
def test_a_wrong_checksum_is_counted_and_its_frame_is_dropped():
    """Packet 40 is a row of the second frame: 24 rows, embedded data, frame packets in each."""
    result = run("imx219", SIZE, 3, more=["+csi2_bad_checksum=40"],
                 fault=Fault("none"), disturb=lambda host: None)
    assert [frame.different for frame in result.frames] == [0] * 3
    assert result.counters["RAW_ENDED_BAD"] == 1


@pytest.mark.regress
@pytest.mark.parametrize("name", ["imx219", "ov5647"])
def test_whole_pictures_of_a_csi2_sensor(name):
    check(run(name, (640, 480), 5, hidden_neurons=8), 5)
