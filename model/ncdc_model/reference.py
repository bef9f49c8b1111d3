"""The corrector in floating point, and the traditional flow, to judge the integer one by."""

import cv2
import numpy as np

from ncdc_model.geometry import WINDOW
from ncdc_model.images import demosaic, mosaic

__all__ = ["bayer_psnr", "correct_real", "grey_level_difference", "psnr"]


def correct_real(descriptor, raw, offset=0.5):
    """Corrected frame (height, width, 3) in real numbers: float network, float interpolation.

    The same fast Bayer interpolation as the hardware's, nothing rounded. Windows that leave the
    image by up to one pixel are moved back in, as in ``picture.window_address``; those further
    out, and pixels without a source, are ``nan``.
    ``offset``: half a pixel between a quad's centre and its first sample; another value shows
    what forgetting it costs.
    """
    geometry = descriptor.geometry
    v, u = np.indices(geometry.corrected[::-1])
    x, y = descriptor.network(*geometry.normalise(u, v))
    blank = ~descriptor.valid.mask(geometry.corrected_width)
    place = []
    for value, size in ((x - offset, geometry.distorted_width),
                        (y - offset, geometry.distorted_height)):
        blank |= (value < -1) | (value >= size - WINDOW + 2)
        place.append(np.clip(value, 0, size - WINDOW + 1))
    quads = _quads(raw.astype(np.float64), geometry.phase)
    result = np.stack([_sample(plane, *place) for plane in quads], axis=-1)
    result[blank] = np.nan
    return result


def grey_level_difference(picture, real):
    """Largest difference in grey levels of uint8 ``picture`` from ``real`` rounded; where ``real``
    is not ``nan``."""
    valid = ~np.isnan(real).any(axis=-1)
    rounded = np.floor(real[valid] + 0.5)
    return int(np.abs(picture[valid].astype(np.int64) - rounded).max(initial=0))


def psnr(picture, reference, mask):
    """Peak signal-to-noise ratio in dB of 8-bit colours over the pixels of ``mask``."""
    error = picture[mask].astype(np.float64) - reference[mask]
    return float(10 * np.log10(255**2 / np.mean(error**2)))


def bayer_psnr(descriptor, colour):
    """What the fast Bayer interpolation costs on one ``colour`` picture (uint8, distorted size).

    The reference is the colour picture itself, remapped bilinearly; every flow gets its mosaic.

    Returns
    -------
    dict
        PSNR in dB: ``psnr_fast_db`` (the corrector's), ``psnr_demosaic_db`` (bilinear
        demosaicing of the frame, then bilinear remapping), ``psnr_uncompensated_db`` (the
        corrector's without the half pixel).
    """
    geometry = descriptor.geometry
    v, u = np.indices(geometry.corrected[::-1])
    x, y = (a.astype(np.float32) for a in descriptor.network(*geometry.normalise(u, v)))
    # Two pixels from the border on, no flow has to invent samples.
    mask = (descriptor.valid.mask(geometry.corrected_width)
            & (x >= 2) & (x <= geometry.distorted_width - 3)
            & (y >= 2) & (y <= geometry.distorted_height - 3))
    raw = mosaic(colour, geometry.bayer)

    def remap(image):
        # In floating point: OpenCV remaps 8-bit pictures with 5 fraction bits only.
        return cv2.remap(image.astype(np.float32), x, y, cv2.INTER_LINEAR)

    reference = remap(colour)
    return {
        "psnr_fast_db": psnr(correct_real(descriptor, raw), reference, mask),
        "psnr_demosaic_db": psnr(remap(demosaic(raw, geometry.bayer)), reference, mask),
        "psnr_uncompensated_db": psnr(correct_real(descriptor, raw, offset=0.0), reference, mask),
    }


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


def _sample(plane, x, y):
    """Bilinear interpolation of ``plane`` at real (x, y), which are within it."""
    x0 = np.minimum(x.astype(np.int64), plane.shape[1] - 2)
    y0 = np.minimum(y.astype(np.int64), plane.shape[0] - 2)
    fx, fy = x - x0, y - y0
    upper = plane[y0, x0] * (1 - fx) + plane[y0, x0 + 1] * fx
    lower = plane[y0 + 1, x0] * (1 - fx) + plane[y0 + 1, x0 + 1] * fx
    return upper * (1 - fy) + lower * fy
