"""Figures of a picture of which the right colours are known."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np

from ncdc_model.reference import psnr

__all__ = ["FIGURES", "Reference", "neighbours", "ssim"]

FIGURES = ("psnr_db", "false_colour", "edge_colour", "overshoot")
_EDGE_SHARE = .1        # of the pixels
_BRIGHTNESS = np.array([.25, .5, .25])


@dataclass(frozen=True)
class Reference:
    """The right colours of a picture, and the pixels that are compared with them.

    Parameters
    ----------
    colour : ndarray, shape (height, width, 3)
    low, high : ndarray, shape (height, width, 3)
        Smallest and largest right value of each colour around the pixel, see :func:`neighbours`.
    mask : ndarray of bool, shape (height, width)
    """
    colour: np.ndarray
    low: np.ndarray
    high: np.ndarray
    mask: np.ndarray

    @cached_property
    def _edges(self):
        """Indices, of the pixels of the mask, of the tenth with the steepest brightness."""
        brightness = self.colour.astype(np.float64) @ _BRIGHTNESS
        slope = np.hypot(*(cv2.Sobel(brightness, cv2.CV_64F, *d) for d in ((1, 0), (0, 1))))
        first = int(self.mask.sum() * (1 - _EDGE_SHARE))
        return np.argpartition(slope[self.mask], first)[first:]

    def figures(self, picture):
        """Figures of a ``picture`` (height, width, 3), by the names in :data:`FIGURES`.

        ``psnr_db``: peak signal-to-noise ratio over all three colours.
        ``false_colour``: root mean square of the errors of R - G and B - G, in grey levels.
        ``edge_colour``: the same at the tenth of the pixels with the steepest brightness, where
        false colour is seen.
        ``overshoot``: by how many grey levels a colour is above ``high`` or below ``low``, mean
        over pixels and colours.
        """
        made = picture[self.mask].astype(np.float64)
        error = made - self.colour[self.mask]
        differences = error[:, ::2] - error[:, 1:2]
        beyond = np.maximum(made - self.high[self.mask], self.low[self.mask] - made).clip(0)
        return {"psnr_db": psnr(picture, self.colour, self.mask),
                "false_colour": _root_mean_square(differences),
                "edge_colour": _root_mean_square(differences[self._edges]),
                "overshoot": float(beyond.mean())}


def neighbours(colour):
    """Smallest and largest values of ``colour`` (height, width, 3) in 3x3 pixels around each."""
    around = np.ones((3, 3), np.uint8)
    return cv2.erode(colour, around), cv2.dilate(colour, around)


def _root_mean_square(values):
    return float(np.sqrt(np.mean(values**2)))


def ssim(picture, reference, mask):
    """Structural similarity (Wang et al., 2004), Gaussian of 11 x 11 pixels and sigma 1.5.

    Mean over the colours, and over the pixels whose whole Gaussian lies in ``mask``.
    """
    a, b = picture.astype(np.float64), reference.astype(np.float64)

    def mean(image):
        return cv2.GaussianBlur(image, (11, 11), 1.5)

    mean_a, mean_b = mean(a), mean(b)
    variance_a, variance_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    covariance = mean(a * b) - mean_a * mean_b
    c1, c2 = (.01 * 255)**2, (.03 * 255)**2
    similarity = ((2 * mean_a * mean_b + c1) * (2 * covariance + c2)
                  / ((mean_a**2 + mean_b**2 + c1) * (variance_a + variance_b + c2)))
    whole = cv2.erode(mask.astype(np.uint8), np.ones((11, 11)), borderValue=0) > 0
    return float(similarity[whole].mean())
