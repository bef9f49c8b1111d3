"""Quality of a corrected picture: the hardware's interpolations and OpenCV's flows."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from ncdc_model.golden.corrector import correct
from ncdc_model.images import demosaic, mosaic
from ncdc_model.reference import psnr
from ncdc_spec.interpolation import CRESTS, DIRECTIONAL, INTERPOLATIONS

__all__ = ["FLOWS", "Subject", "fitted", "measure"]

_RIM = 3            # samples at the raw frame's border that are not compared
# How OpenCV demosaics a frame and how it remaps the result.
_DEMOSAICING = "bilinear", "edge-aware", "vng"
_REMAPPING = {"bilinear": cv2.INTER_LINEAR, "bicubic": cv2.INTER_CUBIC}
_OPENCV = {f"opencv {name}, {way}": (name, way) for name in _DEMOSAICING for way in _REMAPPING}
_CREST = f"{DIRECTIONAL.name}+crest"
FLOWS = (*INTERPOLATIONS, _CREST, *_OPENCV)


@dataclass(frozen=True)
class Subject:
    """A full-colour picture as a camera with a colour filter would see it.

    Parameters
    ----------
    name : str
    colour : ndarray of uint8, shape (distorted height, distorted width, 3)
    """
    name: str
    colour: np.ndarray


def fitted(colour, size):
    """The middle of a ``colour`` picture, in the proportions of ``size``, reduced to it by area."""
    width, height = size
    rows, columns = colour.shape[:2]
    if columns * height > rows * width:
        span = rows * width // height
        colour = colour[:, (columns - span) // 2:][:, :span]
    else:
        span = columns * height // width
        colour = colour[(rows - span) // 2:][:span]
    return cv2.resize(colour, size, interpolation=cv2.INTER_AREA)


def measure(descriptor, subject):
    """Rows of a subject, one for each of :data:`FLOWS`, and the pictures.

    Every flow is given the mosaic of the colour picture. What it makes is compared with that
    picture itself, remapped by the same map, bilinearly and by Lanczos' kernel of 8 x 8 samples.

    Returns
    -------
    list of dict
        ``picture``, ``flow``. ``psnr_db``, ``psnr_lanczos_db``: peak signal-to-noise ratio to
        either reference. ``ssim``: structural similarity to the first one, mean of the colours.
        ``false_colour``: root mean square of the errors of R - G and B - G, in grey levels.
    dict
        Pictures (corrected height, width, 3) uint8 by flow, and ``reference``.
    """
    geometry = descriptor.geometry
    v, u = np.indices(geometry.corrected[::-1])
    x, y = (axis.astype(np.float32) for axis in descriptor.network(*geometry.normalise(u, v)))
    mask = (descriptor.valid.mask(geometry.corrected_width)
            & (x >= _RIM) & (x <= geometry.distorted_width - 1 - _RIM)
            & (y >= _RIM) & (y <= geometry.distorted_height - 1 - _RIM))
    raw = mosaic(subject.colour, geometry.bayer)

    def remap(image, kernel):
        return np.clip(cv2.remap(image.astype(np.float32), x, y, kernel), 0, 255)

    def corrected(interpolation, **options):
        made_for = replace(descriptor, geometry=replace(geometry, interpolation=interpolation))
        return correct(made_for, raw, **options).picture

    made = {name: corrected(each) for name, each in INTERPOLATIONS.items()}
    made[_CREST] = corrected(DIRECTIONAL, crest=CRESTS["mild"])
    made |= {flow: remap(demosaic(raw, geometry.bayer, name), _REMAPPING[way])
             for flow, (name, way) in _OPENCV.items()}
    reference = remap(subject.colour, cv2.INTER_LINEAR)
    lanczos = remap(subject.colour, cv2.INTER_LANCZOS4)
    rows = [{"picture": subject.name, "flow": flow, "psnr_db": psnr(picture, reference, mask),
             "psnr_lanczos_db": psnr(picture, lanczos, mask),
             "ssim": _ssim(picture, reference, mask),
             "false_colour": _false_colour(picture, reference, mask)}
            for flow, picture in made.items()]
    shown = {flow: np.floor(picture.astype(np.float32) + .5).astype(np.uint8)
             for flow, picture in {"reference": reference, **made}.items()}
    return rows, shown


def _ssim(picture, reference, mask):
    """Structural similarity (Wang et al., 2004), Gaussian of 11 x 11 pixels and sigma 1.5."""
    a, b = picture.astype(np.float64), reference.astype(np.float64)

    def mean(image):
        return cv2.GaussianBlur(image, (11, 11), 1.5)

    mean_a, mean_b = mean(a), mean(b)
    variance_a, variance_b = mean(a * a) - mean_a**2, mean(b * b) - mean_b**2
    covariance = mean(a * b) - mean_a * mean_b
    c1, c2 = (.01 * 255)**2, (.03 * 255)**2
    similarity = ((2 * mean_a * mean_b + c1) * (2 * covariance + c2)
                  / ((mean_a**2 + mean_b**2 + c1) * (variance_a + variance_b + c2)))
    # Where all of the Gaussian's window has a source.
    whole = cv2.erode(mask.astype(np.uint8), np.ones((11, 11)), borderValue=0) > 0
    return float(similarity[whole].mean())


def _false_colour(picture, reference, mask):
    """Root mean square of the errors of R - G and B - G."""
    error = picture[mask].astype(np.float64) - reference[mask]
    return float(np.sqrt(np.mean((error[:, ::2] - error[:, 1:2])**2)))
