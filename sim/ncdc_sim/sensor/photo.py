"""A photo that moves before its lens, as the samples of a sensor."""

import cv2
import numpy as np

from ncdc_model.geometry import MONO
from ncdc_model.images import mosaic
from ncdc_model.network import frame_coordinates
from ncdc_model.sensors.sensor import bayer_at
from ncdc_sim.sensor.scene import row_times
from ncdc_sim.sensor.verilog import Light

__all__ = ["moving_photo", "still_raw"]

_FULL = 4095            # of a sensor's sample
_STEPS = 12             # of Newton's iteration: the last ones change less than a thousandth


def still_raw(setup, corner, raw):
    """:class:`Light` of a raw frame of bytes, whose first sample is at ``corner`` of the sensor's
    frame."""
    asked = setup.settings
    return Light(_samples(setup, raw)[None], asked.left + corner[0], asked.top + corner[1])


def moving_photo(descriptor, setup, corner, photo, frames, velocity):
    """:class:`Light` of frames in which what is on a photo moves, as the lens would show it.

    With the map M from corrected to distorted pixels, pixel x of a frame shows the photo at
    M(M^-1(x) - d), with the way d that the scene has gone when the row of x is exposed. Beyond the
    edges of the corrected picture the scene is mirrored.

    Parameters
    ----------
    descriptor : Descriptor
    setup : Setup
    corner : (int, int)
        Column and row of the sensor's frame where the photo begins.
    photo : ndarray of uint8, shape (distorted height, distorted width, 3)
    frames : int
    velocity : (float, float)
        Corrected pixels to the right and down per frame.
    """
    asked, sensor = setup.settings, setup.sensor
    scale = 2.0**-descriptor.formats.coordinate.f_bits
    forward = [(raw * scale).astype(np.float32) for raw in frame_coordinates(descriptor)]
    u, v = _inverse(forward, photo.shape[:2])
    left, top = asked.left + corner[0], asked.top + corner[1]
    bayer = MONO if descriptor.geometry.mono else bayer_at(sensor.bayer, left, top)
    period = setup.timing.frame_clocks / setup.timing.pixel_clock_hz
    made = []
    for number in range(frames):
        times = row_times(setup, number)[corner[1]:corner[1] + len(photo)] / period
        there = (u - velocity[0] * times[:, None], v - velocity[1] * times[:, None])
        there = [array.astype(np.float32) for array in there]
        # What comes in at an edge is the mirrored scene: the edge's own colours would be streaks.
        x, y = (cv2.remap(table, *there, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
                for table in forward)
        moved = cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
        made.append(_samples(setup, mosaic(moved, bayer)))
    return Light(np.array(made), left, top)


def _samples(setup, values):
    """Samples of 12 bits of bytes, 255 the brightest that is told apart from black."""
    return np.round(values * ((_FULL - setup.sensor.black) / 255)).astype(np.uint16)


def _inverse(forward, shape):
    """Corrected (u, v) of every distorted pixel of a picture of ``shape``; where the map does not
    reach, of the nearest place that Newton's iteration finds."""
    height, width = forward[0].shape
    y, x = np.indices(shape, np.float64)
    u, v = x * (width / shape[1]), y * (height / shape[0])
    slopes = [[np.gradient(table, axis=axis).astype(np.float32) for axis in (1, 0)]
              for table in forward]

    def at(table):
        return cv2.remap(table, u.astype(np.float32), v.astype(np.float32), cv2.INTER_LINEAR,
                         borderMode=cv2.BORDER_REPLICATE).astype(np.float64)

    for _ in range(_STEPS):
        dx, dy = x - at(forward[0]), y - at(forward[1])
        (xu, xv), (yu, yv) = [[at(slope) for slope in pair] for pair in slopes]
        scale = xu * yv - xv * yu
        scale = np.where(np.abs(scale) < 1e-3, 1e-3, scale)
        u = np.clip(u + (yv * dx - xv * dy) / scale, -width, 2 * width)
        v = np.clip(v + (xu * dy - yu * dx) / scale, -height, 2 * height)
    return u, v
