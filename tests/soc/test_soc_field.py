"""The whole system in simulation, its sensor reduced: what clients read of it, and its pictures."""

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_sim.system.soc import SocModel, SocRun
from ncdc_spec.sensors.catalogue import controlled_sensor
from peers import need
from soc_clients import OPEN, SIZE, matches, peer

# Compiling the model takes more than a minute.
pytestmark = [pytest.mark.regress, pytest.mark.many_clocks]

_LOOK = OPEN + """
seen = [device.get(name) for name in (
    "SensorWidth", "SensorHeight", "DecimationHorizontal", "DecimationVertical", "FieldLeft",
    "FieldTop")]
with device.stream() as stream:
    take(stream)
    take(stream)
print(json.dumps(seen))
"""


@pytest.mark.parametrize("sensor,part", [
    ("mt9p031", [2592, 1944, 4, 4, 1000, 698]), ("imx219", [3280, 2464, 4, 4, 1000, 700])])
def test_a_field_is_reported_and_its_pictures_are_the_golden_models(tmp_path, sensor, part):
    """Of the IMX219 by its lanes: the firmware sets it up, and the receiver takes its packets."""
    need("riscv64-unknown-elf-gcc", "unshare", "ip", "aravis")
    noise = np.random.default_rng(1).integers(0, 256, SIZE[::-1], dtype=np.uint8)
    bayer = controlled_sensor(sensor).bayer
    descriptor = barrel_descriptor(corrected=SIZE, distorted=SIZE, bayer=bayer)
    model = SocModel(descriptor, cv2.GaussianBlur(noise, (0, 0), 1.0), exposure_us=100.0,
                     field="256x192+1000+700", sensor=sensor)
    with SocRun(model) as run:
        seen = peer(run, _LOOK, tmp_path)
    assert seen == part
    assert matches(tmp_path, 2, [model.golden().picture]) == [0, 0]
