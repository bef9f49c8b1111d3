"""The emulated image sensor and its capture: raw frames by their registers."""

from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np

from ncdc_model.images import mosaic
from ncdc_spec.geometry import BAYER_PHASE
from ncdc_spec.raw_gains import NO_RAW_GAINS, sample_gains
from ncdc_spec.sensors.level import SAMPLE_BITS, levelled

__all__ = ["Exposure", "expose", "test_pattern"]

_SHOT = 0.35 / 16       # variance of the photon noise per grey level at gain 1
_SHIFTS = 64                    # columns and rows by which a frame's noise may be shifted
_BAR_COLOURS = ((255, 255, 255), (255, 255, 0), (0, 255, 255), (0, 255, 0), (255, 0, 255),
                (255, 0, 0), (0, 0, 255), (0, 0, 0))
_FIELD_COLOUR = (165, 90, 170)  # of ColorField


@dataclass(frozen=True)
class Exposure:
    """Settings of sensor and capture that change a frame.

    Parameters
    ----------
    factor : float
        Exposure time over the reference one.
    gain : float
    pattern : str
        Name of the test pattern, "Off" without one.
    noise : float
        Standard deviation of the read noise in grey levels at gain 1; 0: no noise at all.
    raw_gains : tuple of int
        Gains of the colours at capture, in 256ths.
    """
    factor: float
    gain: float
    pattern: str
    noise: float
    raw_gains: tuple = NO_RAW_GAINS


def expose(light, exposure, bayer, seed):
    """Raw uint8 frame of ``light``, the raw frame at factor and gain 1 without noise.

    A grey level becomes light * factor * gain; noise has the variance of photons and of reading,
    and depends on ``seed`` alone. Without noise, factor and all gains 1 return ``light`` itself.
    """
    raw = _sent(light, exposure, bayer, seed)
    if exposure.raw_gains != NO_RAW_GAINS:
        return _captured(raw, bayer, exposure.raw_gains)
    if raw.dtype == np.uint8:
        return raw
    raw += np.float32(0.5)
    return np.clip(np.floor(raw, out=raw), 0, 255, out=raw).astype(np.uint8)


def _sent(light, exposure, bayer, seed):
    """The frame that the sensor makes of ``light``: grey levels, uint8 or real."""
    if exposure.pattern != "Off":
        return test_pattern(exposure.pattern, light.shape[1], light.shape[0], bayer)
    scale = np.float32(exposure.factor * exposure.gain)
    if scale == 1 and not exposure.noise:
        return light
    raw = _each(light, lambda levels: levels * scale)
    if exposure.noise:
        random = _noise(light.shape, seed) * _each(light, lambda levels: np.sqrt(
            levels * (scale * np.float32(_SHOT * exposure.gain))
            + np.float32((exposure.noise * exposure.gain)**2)))
        raw += random
    return raw


def _noise(shape, seed):
    """Normal noise of variance 1: a part of one field, whose position depends on the seed.

    A field of its own for each frame would take half of the time of a picture.
    """
    row, column = np.random.default_rng(seed).integers(_SHIFTS, size=2)
    return _field(shape)[row:row + shape[0], column:column + shape[1]]


@lru_cache(maxsize=2)
def _field(shape):
    return np.random.default_rng(0).standard_normal(np.add(shape, _SHIFTS), np.float32)


def _each(light, function):
    """A ``function`` of each grey level of ``light``, float32; of bytes by a table, for speed."""
    if light.dtype == np.uint8:
        return cv2.LUT(light, function(np.arange(256, dtype=np.float32)))
    return function(light)


def _captured(raw, bayer, gains):
    """The uint8 frame that capture makes of grey levels: of samples of 12 bits, with ``gains``."""
    levels = 1 << SAMPLE_BITS
    samples = np.clip(np.floor(16 * raw.astype(np.float32) + np.float32(0.5)), 0,
                      levels - 1).astype(np.uint16)
    cell = sample_gains((2, 2), BAYER_PHASE.get(bayer), gains)
    captured = np.empty(raw.shape, np.uint8)
    for row, column in np.ndindex(2, 2):
        table = levelled(np.arange(levels), gains=cell[row, column])
        captured[row::2, column::2] = table[samples[row::2, column::2]]
    return captured


def test_pattern(name, width, height, bayer):
    """Raw uint8 frame of the sensor's test pattern of that name."""
    v, u = np.indices((height, width))
    across, down = u * 255 // (width - 1), v * 255 // (height - 1)
    grey = {
        "GreyHorizontalRamp": across,
        "GreyVerticalRamp": down,
        "GreyDiagonalRamp": (u + v) * 255 // (width + height - 2),
        "HorizontalBars": 255 * (v // 16 % 2),
        "VerticalBars": 255 * (u // 16 % 2),
    }
    if name in grey:
        return grey[name].astype(np.uint8)
    colours = np.array([_FIELD_COLOUR] if name == "ColorField" else _BAR_COLOURS, np.uint8)
    return mosaic(colours[u * len(colours) // width], bayer)
