"""A photo that moves before a modelled sensor: times of its rows, what comes in."""

import cv2
import numpy as np

from cameras import barrel_descriptor
from ncdc_model.correction import correct
from ncdc_model.example import noise_picture
from ncdc_sim.sensor.photo import moving_photo, row_times
from ncdc_spec.sensors.catalogue import sensor_named, setup
from ncdc_spec.sensors.framing import setup_around
from ncdc_spec.sensors.sensor import Settings

SIZE = (96, 64)
WAY = 24                # pixels that the scene has gone to the right, about


def test_rows_are_exposed_at_their_own_times():
    plan = setup(sensor_named("mt9p031"), Settings(
        width=48, height=32, left=100, top=60, exposure_us=150, mirror_rows=True))
    for number in range(3):
        # Upside down: the last row is read first.
        lines = number * plan.timing.frame_lines + np.arange(32)[::-1]
        seconds = (lines * plan.timing.line_clocks - plan.exposure_clocks / 2) / 96e6
        assert np.allclose(seconds, row_times(plan, number))


def test_the_edge_where_the_scene_comes_in_has_no_streaks():
    descriptor = barrel_descriptor(SIZE, SIZE, strength=.1)
    plan, corner = setup_around("mt9p031", descriptor.geometry, exposure_us=100)
    noise = cv2.GaussianBlur(noise_picture(*SIZE), (0, 0), 1)
    light = moving_photo(descriptor, plan, corner, np.repeat(noise[..., None], 3, axis=2), 2,
                         (WAY, 0))
    corrected = correct(descriptor, (light.frames[1] >> 4).astype(np.uint8))
    picture = np.where(corrected.blank, np.nan, corrected.picture[..., 1].astype(float))
    changes = np.nanmean(np.abs(np.diff(picture, axis=1)), axis=0)
    assert changes[2:WAY - 4].mean() > changes[WAY:].mean() / 2
