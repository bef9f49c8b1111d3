"""How a sensor with a colour filter sees a full-colour picture: noise, white balance, light."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.golden.tone import exact_tone
from ncdc_model.images import mosaic

__all__ = ["CONDITIONS", "Condition"]


@dataclass(frozen=True)
class Condition:
    """How a sensor sees a picture.

    Parameters
    ----------
    noise : float
        Standard deviation of normal noise, in grey levels of a sample.
    gains : tuple of float
        Sensitivity for red, green and blue; the colours are divided by it after decoding.
    balanced_first : bool
        Whether the samples are divided by it instead, before decoding.
    linear : bool
        Whether samples measure linear light. Decoded colours are then encoded as sRGB.
    """
    noise: float = 0.0
    gains: tuple = (1.0, 1.0, 1.0)
    balanced_first: bool = False
    linear: bool = False

    def truth(self, colour):
        """What a sensor with all three colours at each sample would show of ``colour``.

        With ``linear`` it has 8 bits of light, so that the loss by them is not counted.
        """
        return exact_tone("sRGB", _rounded(_light(colour))) if self.linear else colour

    def raw(self, colour, bayer, rng):
        """The raw frame (height, width) of uint8 of a ``colour`` picture (height, width, 3)."""
        gains = np.array(self.gains)
        samples = mosaic((_light(colour) if self.linear else colour) * gains, bayer)
        raw = _rounded(samples + self.noise * rng.standard_normal(samples.shape))
        if self.balanced_first:
            raw = _rounded(raw / mosaic(np.broadcast_to(gains, colour.shape), bayer))
        return raw.astype(np.uint8)

    def shown(self, decoded):
        """Colours in 0..255, on the scale of :meth:`truth`, of a ``decoded`` raw frame."""
        balanced = decoded if self.balanced_first else np.minimum(decoded / self.gains, 255)
        return exact_tone("sRGB", balanced) if self.linear else balanced


def _rounded(values):
    return np.clip(np.floor(values + .5), 0, 255)


def _light(colour):
    """Linear light, 0..255, of sRGB code values, IEC 61966-2-1."""
    x = np.asarray(colour, float) / 255
    return 255 * np.where(x <= .04045, x / 12.92, ((x + .055) / 1.055)**2.4)


_UNBALANCED = (0.5, 1.0, 0.6)
CONDITIONS = (Condition(), *(Condition(noise=sigma) for sigma in (2.0, 5.0, 10.0)),
              Condition(gains=_UNBALANCED), Condition(gains=_UNBALANCED, balanced_first=True),
              Condition(linear=True))
