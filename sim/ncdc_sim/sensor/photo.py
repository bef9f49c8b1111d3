"""A photo that moves before its lens, as the samples of a sensor."""

from itertools import product

import cv2
import numpy as np

from ncdc_model.correction import frame_coordinates
from ncdc_model.images import mosaic
from ncdc_sim.sensor.verilog import Light
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MONO
from ncdc_spec.sensors.framing import Crop, grid_offset
from ncdc_spec.sensors.sensor import bayer_at

__all__ = ["moving_photo", "row_times", "still_raw"]

_FULL = 4095            # of a sensor's sample
_MAX_BYTES = 2 << 30    # of samples of a moving photo
_STEPS = 12             # of Newton's iteration: the last ones change less than a thousandth


def still_raw(setup, crop, raw):
    """:class:`Light` of a raw frame of bytes, from which capture's :class:`Crop` gives that frame.

    With a sensor that reduces, each active pixel is interpolated linearly between two pixels of its
    colour in ``raw``. Reduced and evened they give ``raw`` again, but for its finest detail.
    """
    asked, crop = setup.settings, Crop(*crop)
    if asked.skip == 1 and not crop.grid:
        return Light(_samples(setup, raw)[None], asked.left + crop.left, asked.top + crop.top)
    x, y = _sources(setup, crop, raw.shape)
    active = np.empty((len(y), len(x)), np.float32)
    for row, column in product((0, 1), (0, 1)):
        # The raw frame begins so many samples, hence so many colours, into what the sensor sends.
        plane = raw[(row + crop.top) % 2::2, (column + crop.left) % 2::2].astype(np.float32)
        u = (x[column::2] - (column + crop.left) % 2) / 2
        v = (y[row::2] - (row + crop.top) % 2) / 2
        active[row::2, column::2] = _between(plane, u, v)
    return Light(_samples(setup, active)[None], asked.left, asked.top)


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


def moving_photo(descriptor, setup, crop, photo, frames, velocity):
    """:class:`Light` of frames in which what is on a photo moves, as the lens would show it.

    With the map M from corrected to distorted pixels, pixel x of a frame shows the photo at
    M(M^-1(x) - d). Here d is the scene's displacement when the row of x is exposed. Beyond the
    edges of the corrected picture the scene is mirrored.

    Parameters
    ----------
    descriptor : Descriptor
    setup : Setup
    crop : Crop
        The part of the sensor's frames that capture keeps: there the photo begins.
    photo : ndarray of uint8, shape (distorted height, distorted width, 3)
    frames : int
    velocity : (float, float)
        Corrected pixels to the right and down per frame.
    """
    asked, sensor, crop = setup.settings, setup.sensor, Crop(*crop)
    reduced = asked.skip > 1 or crop.grid
    scale = 2.0**-descriptor.formats.coordinate.f_bits
    forward = [(raw * scale).astype(np.float32) for raw in frame_coordinates(descriptor)]
    u, v = _inverse(forward, photo.shape[:2])
    left, top = asked.left, asked.top
    if reduced:
        _check_bytes(setup, crop, frames)
        coordinates = _sources(setup, crop, photo.shape)
    else:
        left, top = left + crop.left, top + crop.top
    bayer = MONO if descriptor.geometry.mono else bayer_at(sensor.bayer, left, top)
    period = setup.timing.frame_clocks / setup.timing.pixel_clock_hz
    made = []
    for number in range(frames):
        # With rows binned in the FPGA, at the first one of each pair.
        rows = crop.top + np.arange(len(photo)) << crop.binning
        times = row_times(setup, number)[rows] / period
        there = (u - velocity[0] * times[:, None], v - velocity[1] * times[:, None])
        there = [array.astype(np.float32) for array in there]
        # What comes in at an edge is the mirrored scene: the edge's own colours would be streaks.
        x, y = (cv2.remap(table, *there, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
                for table in forward)
        moved = cv2.remap(photo, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT_101)
        if reduced:
            moved = np.rint(_between(moved.astype(np.float32), *coordinates)).astype(np.uint8)
        made.append(_samples(setup, mosaic(moved, bayer)))
    return Light(np.array(made), left, top)


def _samples(setup, values):
    """Samples of 12 bits of bytes; 255 becomes the brightest sample after the black level."""
    return np.round(values * ((_FULL - setup.sensor.black) / 255)).astype(np.uint16)


def _sources(setup, crop, shape):
    """Where in raw frames of ``shape``, (height, width, ...), the active pixels of the sensor's
    window lie: columns, rows."""
    asked = setup.settings
    reduction, found = asked.skip << crop.binning, []
    for begin, sent, corner in ((asked.left, asked.width, crop.left),
                                (asked.top, asked.height, crop.top)):
        first = begin + reduction * corner + grid_offset(setup, crop)
        active = begin + np.arange(asked.skip * sent)
        found.append((active - first + .5) / reduction - .5)
    return found


def _between(values, x, y):
    """``values`` (height, width, ...) at columns ``x`` and rows ``y``, linear, constant outside."""
    grid = np.meshgrid(np.float32(x), np.float32(y))
    return cv2.remap(values, *grid, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)


def _check_bytes(setup, crop, frames):
    """Raises :class:`InputError` if frames of all active pixels take too much memory."""
    asked = setup.settings
    one = 2 * asked.skip**2 * asked.width * asked.height
    if frames * one > _MAX_BYTES:
        raise InputError(
            f"{frames} frames of the {asked.skip * asked.width}x{asked.skip * asked.height} pixels "
            f"that the {setup.sensor.name} reads take {frames * one / 1e9:.1f} GB: at most "
            f"{_MAX_BYTES // one} fit, or a field that is not reduced")


def _inverse(forward, shape):
    """Corrected (u, v) of every distorted pixel of a picture of ``shape``.

    Outside the map's range they are those of the nearest point that Newton's iteration finds.
    """
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
