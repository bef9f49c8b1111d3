"""A system whose sensor reads its field reduced: pictures equal the golden model's."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_hdl.system import System
from ncdc_sim.sensor.photo import moving_photo
from ncdc_sim.system.camera import simulate_camera
from ncdc_spec.hardware import Hardware
from ncdc_spec.sensors.framing import grid_row, setup_around

SIZE = (64, 24)


@pytest.mark.longer
@pytest.mark.parametrize("name,field", [
    ("mt9p031", "256x96"), *(pytest.param(*each, marks=pytest.mark.regress) for each in (
        ("mt9p031", "full"), ("mt9p031", "128x48"), ("ov5640", "full"), ("mt9d111", "128x48")))])
def test_pictures_of_a_reduced_field(name, field):
    """Sensor, its registers by I2C, the grid stage, memory and corrector, all in Verilog."""
    descriptor = barrel_descriptor(SIZE, SIZE, hidden_neurons=2, strength=.4)
    plan, crop = setup_around(name, descriptor.geometry, field=field, exposure_us=100)
    assert plan.settings.skip > 1 and crop.weight
    photo = np.random.default_rng(1).integers(0, 256, (*SIZE[::-1], 3), np.uint8)
    light = moving_photo(descriptor, plan, crop, photo, 3, (5, 0))
    system = System(descriptor, Hardware(data_width=64), grid=grid_row(plan, crop))
    run = simulate_camera(system, plan, light, corner=crop, count=3)
    assert [frame.different for frame in run.frames] == [0, 0, 0]
    # The scene moves: three pictures, not one.
    assert len({frame.picture.tobytes() for frame in run.frames}) == 3
