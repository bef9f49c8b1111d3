"""A moving scene: each row at the time of its own exposure, in the colours of the sensor."""

import numpy as np
import pytest

from ncdc_model.lens import Camera
from ncdc_sim.sensor.reference import raw_frames
from ncdc_sim.sensor.scene import moving_light, row_times
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.sensor import Settings

SIZE = (48, 32)
CAMERA = Camera.from_dict({"width": SIZE[0], "height": SIZE[1], "radial": "kb",
                           "k": [0.03, 0.01, 0, 0], "centre": [23.5, 15.5],
                           "f_distorted": 30.0})
SPEED = 4000.0           # grey levels per second


def plan_of(**asked):
    return setup(sensor_named("mt9p031"), Settings(
        width=SIZE[0], height=SIZE[1], left=100, top=60, exposure_us=150, **asked))


def slope(a, b):
    """Light that rises to the left, so that at each point it rises with what moves to the right."""
    return np.repeat((100 - 20 * a)[..., None], 3, axis=2)


def test_rows_see_the_scene_at_their_own_times():
    plan = plan_of(mirror_rows=True)
    moving = moving_light(CAMERA, plan, 3, (SPEED / 20, 0), slope).frames.astype(float)
    still = moving_light(CAMERA, plan, 1, (0, 0), slope).frames[0].astype(float)
    scale = (4095 - 168) / 255
    for number in range(3):
        # Upside down: the last row is read first.
        lines = number * plan.timing.frame_lines + np.arange(SIZE[1])[::-1]
        seconds = (lines * plan.timing.line_clocks - plan.exposure_clocks / 2) / 96e6
        assert np.allclose(seconds, row_times(plan, number))
        rise = moving[number] - still
        assert np.abs(rise - scale * SPEED * seconds[:, None]).max() <= 1.0
    assert (moving[1] - moving[0]).min() > 20


def test_colours_and_brightness_are_those_of_the_scene():
    def red(a, b):
        return np.broadcast_to([200.0, 100, 50], (*np.broadcast(a, b).shape, 3))

    for asked in ({}, {"mirror_columns": True}, {"mirror_rows": True, "gain_db": 12}):
        plan = plan_of(**asked)
        frame = raw_frames(plan, moving_light(CAMERA, plan, 1, scene=red))[0]
        for k, colour in enumerate(plan.bayer):
            level = {"R": 200, "G": 100, "B": 50}[colour] * (4095 - 168) / 255 + 168
            assert np.abs(frame[k // 2::2, k % 2::2] - level).max() <= 1, (asked, colour)


def test_a_camera_of_another_size():
    plan = setup(sensor_named("mt9p031"), Settings(width=50, height=32))
    with pytest.raises(InputError, match="the window is 50x32, the camera's picture 48x32"):
        moving_light(CAMERA, plan, 1)
