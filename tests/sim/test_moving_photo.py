"""A photo that moves before a modelled sensor: what comes in at its edges."""

import cv2
import numpy as np

from cameras import barrel_descriptor
from ncdc_model.example import noise_picture
from ncdc_model.golden.corrector import correct
from ncdc_sim.sensor.photo import moving_photo
from ncdc_spec.sensors.framing import setup_around

SIZE = (96, 64)
WAY = 24                # pixels that the scene has gone to the right, about


def test_the_edge_where_the_scene_comes_in_has_no_streaks():
    descriptor = barrel_descriptor(SIZE, SIZE, strength=.1)
    setup, corner = setup_around("mt9p031", descriptor.geometry, exposure_us=100)
    noise = cv2.GaussianBlur(noise_picture(*SIZE), (0, 0), 1)
    light = moving_photo(descriptor, setup, corner, np.repeat(noise[..., None], 3, axis=2), 2,
                         (WAY, 0))
    corrected = correct(descriptor, (light.frames[1] >> 4).astype(np.uint8))
    picture = np.where(corrected.blank, np.nan, corrected.picture[..., 1].astype(float))
    changes = np.nanmean(np.abs(np.diff(picture, axis=1)), axis=0)
    assert changes[2:WAY - 4].mean() > changes[WAY:].mean() / 2
