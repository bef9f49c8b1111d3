"""Simulates a sensor and a known lens: exact rays, supersampling, colour filter, noise."""

import numpy as np

from ncdc_model.images import mosaic

__all__ = ["expose", "ideal_samples", "sensor"]

SUBSAMPLES = 3         # per pixel and axis, centred on the pixel
_KNOTS = 4             # pixels between the exact inverses of the ray field


def ideal_samples(camera):
    """Ideal points (a, b) of all subsamples of ``camera``'s image, each (3 height, 3 width).

    The lens is inverted exactly on a grid of every fourth pixel; a bicubic spline through it
    differs from the inverse by less than 1e-4 pixels in between.
    """
    from scipy.interpolate import RectBivariateSpline  # takes 30 MB

    width, height = camera.size
    kx = np.arange(-_KNOTS, width + 2 * _KNOTS, _KNOTS)
    ky = np.arange(-_KNOTS, height + 2 * _KNOTS, _KNOTS)
    a, b = camera.undistort(*np.meshgrid(kx, ky))
    offset = (np.arange(SUBSAMPLES) - (SUBSAMPLES - 1) / 2) / SUBSAMPLES
    xs, ys = ((np.arange(size)[:, None] + offset).ravel() for size in (width, height))
    return tuple(RectBivariateSpline(ky, kx, field)(ys, xs) for field in (a, b))


def expose(samples):
    """Mean of the subsamples of each pixel of ``samples`` (3 height, 3 width[, channels])."""
    height, width = (size // SUBSAMPLES for size in samples.shape[:2])
    blocks = samples.reshape(height, SUBSAMPLES, width, SUBSAMPLES, *samples.shape[2:])
    return blocks.mean(axis=(1, 3))


def sensor(light, bayer, seed, gain=0.35, read=0.8):
    """Raw uint8 frame of linear ``light`` (h, w, 3) in 0..255 through a colour filter.

    Noise is Gaussian with variance ``gain`` * light / 16 + ``read``**2: photon and read noise in
    counts; rounded to nearest and clipped.
    """
    raw = mosaic(np.asarray(light, np.float64), bayer)
    noise = np.random.default_rng(seed).standard_normal(raw.shape)
    raw = raw + noise * np.sqrt(gain * np.maximum(raw, 0) / 16 + read * read)
    return np.clip(np.floor(raw + 0.5), 0, 255).astype(np.uint8)
