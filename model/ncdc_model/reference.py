"""The corrector in floating point and the traditional flow, for comparison with the integers."""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_model.golden.directional import twice_direction
from ncdc_model.golden.picture import raw_windows
from ncdc_model.images import demosaic, mosaic
from ncdc_spec.interpolation import DIRECTIONAL, FAST, INTERPOLATIONS

__all__ = ["bayer_psnr", "correct_real", "grey_level_difference", "psnr"]


def correct_real(descriptor, raw, offset=None, at=None, crest=0):
    """Corrected frame (height, width, 3) in real numbers: float network, float interpolation.

    The Bayer interpolation is that of the hardware, without rounding. Sources up to one pixel
    outside the image are clamped to it, as in ``picture.window_address``. Pixels farther outside or
    without a source are ``nan``.
    ``offset``: by default that of the interpolation (half a pixel between a quad's centre and its
    first sample); another value shows the error without it. ``at``: (x', y') of every corrected
    pixel, by default the float network's. The directional interpolation decides anew from sample
    to sample, so that it shows a difference of coordinates there. ``crest``: its strength, 0 to 2.
    """
    geometry = descriptor.geometry
    interpolation = geometry.interpolation
    offset = interpolation.offset if offset is None else offset
    v, u = np.indices(geometry.corrected[::-1])
    x, y = descriptor.network(*geometry.normalise(u, v)) if at is None else at
    blank = ~descriptor.valid.mask(geometry.corrected_width)
    source = []
    for value, size in ((x - offset, geometry.distorted_width),
                        (y - offset, geometry.distorted_height)):
        blank |= (value < -1) | (value >= size - interpolation.core + 2)
        source.append(np.clip(value, 0, size - interpolation.core + 1))
    samples = raw.astype(np.float64)

    def picture(planes):
        return np.stack([_sample(plane, *source) for plane in planes], axis=-1)

    if interpolation == DIRECTIONAL and not geometry.mono:
        x0, y0 = (np.minimum(value.astype(np.int64), size - 2)
                  for value, size in zip(source, geometry.distorted))
        twice = twice_direction(raw_windows(raw, interpolation)[y0, x0])[..., None]
        result = sum((twice == each) * picture(_directional(samples, geometry.phase, each / 2))
                     for each in range(-2, 3))
    else:
        planes = (_grey if geometry.mono else _quads if interpolation == FAST
                  else _gradient_corrected)
        result = picture(planes(samples, geometry.phase))
    if crest:
        result += crest * _crest(samples, *source)[..., None]
    result = result.clip(0, 255)
    result[blank] = np.nan
    return result


def grey_level_difference(picture, real):
    """Largest difference in grey levels of uint8 ``picture`` from rounded ``real``, where ``real``
    is not ``nan``."""
    valid = ~np.isnan(real).any(axis=-1)
    rounded = np.floor(real[valid] + 0.5)
    return int(np.abs(picture[valid].astype(np.int64) - rounded).max(initial=0))


def psnr(picture, reference, mask):
    """Peak signal-to-noise ratio in dB of 8-bit colours over the pixels of ``mask``."""
    error = picture[mask].astype(np.float64) - reference[mask]
    return float(10 * np.log10(255**2 / np.mean(error**2)))


def bayer_psnr(descriptor, colour):
    """PSNR of each Bayer interpolation on one ``colour`` picture (uint8, distorted size).

    The reference is the colour picture itself, remapped bilinearly; every flow gets its mosaic.

    Returns
    -------
    dict
        ``psnr_fast_db``, ``psnr_gradient_db``, ``psnr_directional_db`` (the corrector's, by its
        interpolation), ``psnr_demosaic_db`` (bilinear demosaicing and remapping),
        ``psnr_uncompensated_db`` (the fast one without the half pixel).
    """
    geometry = descriptor.geometry
    v, u = np.indices(geometry.corrected[::-1])
    x, y = (a.astype(np.float32) for a in descriptor.network(*geometry.normalise(u, v)))
    # All samples exist for every flow from two pixels off the border on.
    mask = (descriptor.valid.mask(geometry.corrected_width)
            & (x >= 2) & (x <= geometry.distorted_width - 3)
            & (y >= 2) & (y <= geometry.distorted_height - 3))
    raw = mosaic(colour, geometry.bayer)

    def remap(image):
        # OpenCV remaps 8-bit pictures with 5 fraction bits only, so use floating point.
        return cv2.remap(image.astype(np.float32), x, y, cv2.INTER_LINEAR)

    flows = {name: replace(descriptor, geometry=replace(geometry, interpolation=each))
             for name, each in INTERPOLATIONS.items()}
    reference = remap(colour)
    return {
        **{f"psnr_{name}_db": psnr(correct_real(each, raw), reference, mask)
           for name, each in flows.items()},
        "psnr_demosaic_db": psnr(remap(demosaic(raw, geometry.bayer)), reference, mask),
        "psnr_uncompensated_db": psnr(correct_real(flows[FAST.name], raw, offset=0.0), reference,
                                      mask),
    }


def _grey(raw, phase):
    """Red, green, blue planes of a grey sensor: the samples themselves."""
    return raw, raw, raw


def _quads(raw, phase):
    """Red, green, blue planes: the colour of the quad of 2x2 samples from each sample on."""
    column, row = phase
    is_red = np.zeros(raw.shape, bool)
    is_red[row::2, column::2] = True
    is_blue = np.zeros(raw.shape, bool)
    is_blue[1 - row::2, 1 - column::2] = True

    def total(plane):
        return plane[:-1, :-1] + plane[:-1, 1:] + plane[1:, :-1] + plane[1:, 1:]

    return (total(np.where(is_red, raw, 0)), total(np.where(is_red | is_blue, 0, raw)) / 2,
            total(np.where(is_blue, raw, 0)))


def _around(raw):
    """A function that gives the mean of the samples at (rows, columns) from every sample."""
    framed = np.pad(raw, 2, mode="reflect")

    def mean(*offsets):
        return sum(framed[2 + down:, 2 + across:][:raw.shape[0], :raw.shape[1]]
                   for down, across in offsets) / len(offsets)
    return mean


def _planes(raw, phase, along, down, green, chroma):
    """Red, green, blue planes of what each sample lacks: the colour of its row and of its column
    (green samples), green and the other chroma (red and blue ones)."""
    column, row = phase
    v, u = np.indices(raw.shape)
    red_row, red_column = (v - row) % 2 == 0, (u - column) % 2 == 0
    red = np.select([red_row & red_column, red_row, red_column], [raw, along, down], chroma)
    blue = np.select([~red_row & ~red_column, ~red_row, ~red_column], [raw, along, down], chroma)
    return red, np.where(red_row == red_column, green, raw), blue


def _directional(raw, phase, s):
    """Red, green, blue planes of the directional interpolation for one direction ``s``, -1 to 1.

    Along a row, the colour difference of a sample is interpolated from those next to it in the
    row, along a column likewise; ``s`` is the share of the row less that of the column.
    """
    mean = _around(raw)
    left_right, above_below = mean((0, -1), (0, 1)), mean((-1, 0), (1, 0))
    far_row, far_column = mean((0, -2), (0, 2)), mean((-2, 0), (2, 0))
    corners = mean((-1, -1), (-1, 1), (1, -1), (1, 1))
    bend = raw - (far_row + far_column) / 2
    turn = 3 / 8 * (left_right - above_below) - (far_row - far_column) / 8
    green = (left_right + above_below) / 2 + 3 / 8 * bend + s * turn
    chroma = corners + bend / 2 + 2 * s * turn

    def at_green(near, far, knights, s):
        first = near + (raw - far) / 4
        second = raw + (near + knights) / 2 - corners
        return (first + second) / 2 + s * (first - second) / 2

    tall = mean((-2, -1), (-2, 1), (2, -1), (2, 1))
    wide = mean((-1, -2), (-1, 2), (1, -2), (1, 2))
    return _planes(raw, phase, at_green(left_right, far_row, tall, s),
                   at_green(above_below, far_column, wide, -s), green, chroma)


def _crest(raw, x, y):
    """What a crest of strength 1 adds to the colours at real (x, y), in grey levels.

    It is the second difference of the samples around, along the row and along the column, with a
    weight that rises in steps from 0 at a sample to the middle between two.
    """
    framed = np.pad(raw, 1, mode="reflect")
    weights = np.array([0, 1, 2, 2, 3, 3, 4, 4]) / 256

    def along(framed, x, y):
        x0 = np.minimum(x.astype(np.int64), framed.shape[1] - 4)
        y0 = np.minimum(y.astype(np.int64), framed.shape[0] - 4)
        bend = framed[:, 1:-2] + framed[:, 2:-1] - framed[:, :-3] - framed[:, 3:]
        f = x - x0
        step = np.minimum(np.floor(16 * f), np.ceil(16 * (1 - f)) - 1).astype(np.int64)
        return weights[step.clip(0)] * (bend[y0 + 1, x0] + bend[y0 + 2, x0])

    return along(framed, x, y) + along(framed.T, y, x)


def _gradient_corrected(raw, phase):
    """Red, green, blue planes: the colour of each sample by Malvar, He and Cutler (2004).

    It is the bilinear estimate of a missing colour plus a part of the difference of the sample from
    the mean of the nearest ones of its own colour: 1/2 for green, 5/8 for a chroma at a green
    sample, 3/4 for the other chroma.
    """
    mean = _around(raw)
    side, above = mean((0, -1), (0, 1)), mean((-1, 0), (1, 0))
    corners = mean((-1, -1), (-1, 1), (1, -1), (1, 1))
    far_side, far_above = mean((0, -2), (0, 2)), mean((-2, 0), (2, 0))
    step = raw - (far_side + far_above) / 2
    green = (side + above) / 2 + step / 2
    chroma = corners + 3 / 4 * step
    # The nearest greens around a green sample are the corners and the far ones along the line; the
    # far ones across it have a negative weight.
    along = 5 / 8 * (raw - (4 * corners + 2 * far_side - far_above) / 5)
    across = 5 / 8 * (raw - (4 * corners + 2 * far_above - far_side) / 5)
    return _planes(raw, phase, side + along, above + across, green, chroma)


def _sample(plane, x, y):
    """Bilinear interpolation of ``plane`` at real (x, y), which are within it."""
    x0 = np.minimum(x.astype(np.int64), plane.shape[1] - 2)
    y0 = np.minimum(y.astype(np.int64), plane.shape[0] - 2)
    fx, fy = x - x0, y - y0
    upper = plane[y0, x0] * (1 - fx) + plane[y0, x0 + 1] * fx
    lower = plane[y0 + 1, x0] * (1 - fx) + plane[y0 + 1, x0 + 1] * fx
    return upper * (1 - fy) + lower * fy
