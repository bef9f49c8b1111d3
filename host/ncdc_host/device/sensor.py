"""The emulated image sensor: raw frames by its registers."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.images import mosaic
from ncdc_spec.protocols.features import TEST_PATTERNS

__all__ = ["Exposure", "expose", "test_pattern"]

_SHOT = 0.35 / 16       # variance of the photon noise per grey level at gain 1
_BAR_COLOURS = ((255, 255, 255), (255, 255, 0), (0, 255, 255), (0, 255, 0), (255, 0, 255),
                (255, 0, 0), (0, 0, 255), (0, 0, 0))
_MODES = {choice.name: choice.word for choice in TEST_PATTERNS}


@dataclass(frozen=True)
class Exposure:
    """Settings of the sensor that change a frame.

    Parameters
    ----------
    factor : float
        Exposure time over the reference one.
    gain : float
    pattern : int
        Value of the test pattern register.
    noise : float
        Standard deviation of the read noise in grey levels at gain 1; 0: no noise at all.
    """
    factor: float
    gain: float
    pattern: int
    noise: float


def expose(light, exposure, bayer, seed):
    """Raw uint8 frame of ``light``, the raw frame at factor and gain 1 without noise.

    A grey level becomes light * factor * gain; noise has the variance of photons and of reading,
    and depends on ``seed`` alone. Without noise, factor and gain 1 return ``light`` itself.
    """
    if exposure.pattern:
        return test_pattern(exposure.pattern, light.shape[1], light.shape[0], bayer)
    scale = np.float32(exposure.factor * exposure.gain)
    if scale == 1 and not exposure.noise:
        return light
    raw = light * scale
    if exposure.noise:
        variance = raw * np.float32(_SHOT * exposure.gain) + np.float32(
            (exposure.noise * exposure.gain)**2)
        random = np.random.default_rng(seed).standard_normal(light.shape, np.float32)
        raw += random * np.sqrt(variance)
    return np.clip(np.floor(raw + np.float32(0.5)), 0, 255).astype(np.uint8)


def test_pattern(word, width, height, bayer):
    """Raw uint8 frame that the sensor makes when its test pattern register holds ``word``."""
    v, u = np.indices((height, width))
    across, down = u * 255 // (width - 1), v * 255 // (height - 1)
    grey = {
        _MODES["GreyHorizontalRamp"]: across,
        _MODES["GreyVerticalRamp"]: down,
        _MODES["GreyDiagonalRamp"]: (u + v) * 255 // (width + height - 2),
        _MODES["HorizontalBars"]: 255 * (v // 16 % 2),
        _MODES["VerticalBars"]: 255 * (u // 16 % 2),
    }
    if word in grey:
        return grey[word].astype(np.uint8)
    colours = np.array(_BAR_COLOURS, np.uint8)
    return mosaic(colours[u * len(colours) // width], bayer)
