"""A scene that moves before a lens and a rolling shutter, as the samples of a sensor."""

import numpy as np

from ncdc_model.example import scene_at
from ncdc_model.example.render import SUBSAMPLES, expose, ideal_samples
from ncdc_model.images import mosaic
from ncdc_sim.sensor.verilog import Light
from ncdc_spec.errors import InputError
from ncdc_spec.sensors.sensor import bayer_at

__all__ = ["moving_light", "row_times"]

_WHITE = 255            # of a scene
_FULL = 4095            # of a sample


def row_times(setup, frame):
    """Seconds of the middle of the exposure of a frame's rows, from the window's top on.

    Rows are read one a line, in the configured order; time 0 is the begin of the reading of
    frame 0. Motion during an exposure is not blurred.
    """
    timing = setup.timing
    lines = frame * timing.frame_lines + np.arange(timing.height)
    middle = lines * timing.line_clocks - setup.exposure_clocks / 2
    order = np.argsort(setup.rows)
    return middle[order] / timing.pixel_clock_hz


def moving_light(camera, setup, frames, velocity=(0.3, 0.0), scene=scene_at):
    """:class:`Light` of ``frames`` frames of a scene that moves before ``camera``.

    With the exposure and the gain of ``setup`` the light of 255 is the brightest sample, black
    level included. The lens lies over the window of ``setup``.

    Parameters
    ----------
    camera : Camera
    setup : Setup
        Its window has the size of the camera's picture.
    frames : int
    velocity : (float, float)
        Ideal units per second by which the scene moves to the right and down.
    scene : callable
        ``scene(a, b)`` is the light (..., 3) in 0..255 of ideal points.

    Raises
    ------
    InputError
        If the sizes differ.
    """
    asked, sensor = setup.settings, setup.sensor
    if (asked.width, asked.height) != tuple(camera.size):
        raise InputError(f"the window is {asked.width}x{asked.height}, the camera's picture "
                         f"{camera.size[0]}x{camera.size[1]}")
    a, b = ideal_samples(camera)
    bayer = bayer_at(sensor.bayer, asked.left, asked.top)
    made = []
    for number in range(frames):
        times = np.repeat(row_times(setup, number), SUBSAMPLES)[:, None]
        light = expose(scene(a - velocity[0] * times, b - velocity[1] * times))
        samples = mosaic(light, bayer) * ((_FULL - sensor.black) / _WHITE)
        made.append(np.clip(np.floor(samples + 0.5), 0, _FULL).astype(np.uint16))
    nominal = setup.exposure_clocks * setup.gain_256 // 256
    return Light(np.array(made), asked.left, asked.top, nominal)
