"""Views in a camera system: each frame shows the view that was committed, and its own raw frame."""

import numpy as np
import pytest

from ncdc_hdl.system import System
from ncdc_model.correction import correct
from ncdc_sim.sensor.verilog import Light
from ncdc_sim.system.running import running
from ncdc_spec.hardware import Hardware
from ncdc_spec.registers.register_map import CTRL_COMMIT
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings
from ncdc_spec.view import VIEW_REGISTERS
from ncdc_spec.view_matrix import Angles, PlaneCamera
from plane_lens import seen_lens

SIZE = 64, 32
LIMIT = 2_000_000       # clocks for a frame to come


@pytest.fixture(scope="module")
def system():
    return System(seen_lens(SIZE, 40.0, (31.0, 16.5)), Hardware(data_width=64, view=True))


def committed(view):
    """Writes that make a view that of the next frame."""
    return dict(zip(VIEW_REGISTERS, view.matrix)) | {"CTRL": CTRL_COMMIT}


@pytest.mark.longer
@pytest.mark.parametrize("follow", [pytest.param(False, marks=pytest.mark.regress), True])
def test_views_of_a_running_camera(system, follow):
    lens, sensor = system.descriptor, sensor_named("mt9p031")
    first, second = (PlaneCamera.of(lens).looking(angles) for angles in (
        Angles(pan=12, tilt=-5, roll=20, zoom=1.4), Angles(pan=-8, roll=-170, zoom=.8)))
    asked = setup(sensor, Settings(width=SIZE[0], height=SIZE[1], exposure_us=100,
                                   clock_hz=sensor.pixel_clock_hz))
    noise = np.random.default_rng(1).integers(0, 4096, (6, *SIZE[::-1]), dtype=np.uint16)
    shown = []
    with running(system, asked, Light(noise),
                 registers={"RUN_FOLLOW": int(follow), **committed(first)}) as camera:
        host = camera.host
        host.camera.listen("CORRECTED_FRAME", "CORRECTED_BAD", "RAW_BAD")
        while len(shown) < 4:
            assert host.live.wait_irq(LIMIT)
            events = host.camera.events()
            assert "CORRECTED_FRAME" in events and not events & {"CORRECTED_BAD", "RAW_BAD"}
            frame = host.claim()
            picture = host.picture(frame)
            shown.append([view for view in (first, second) if np.array_equal(
                picture, correct(lens, camera.sent(frame.number), view=view).picture)])
            host.camera.release(0)
            if len(shown) == 1:
                host.camera.put(**committed(second))
        assert host.get("CORRECTED_ENDED_BAD") == 0
    # A frame that had begun before the commit shows the view before.
    assert shown[0] == [first] and shown[1] in ([first], [second])
    assert shown[2:] == [[second]] * 2
