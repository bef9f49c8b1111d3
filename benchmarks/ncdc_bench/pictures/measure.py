"""Quality of a corrected picture: the hardware's interpolations, and others' flows."""

from dataclasses import dataclass, replace

import cv2
import numpy as np

from ncdc_bench.pictures.metrics import FIGURES, Reference, neighbours, ssim
from ncdc_bench.pictures.peers import PEERS, decoded
from ncdc_model.correction import correct
from ncdc_model.images import mosaic
from ncdc_model.reference import psnr
from ncdc_spec.interpolation import CRESTS, DIRECTIONAL, INTERPOLATIONS

__all__ = ["FLOWS", "Subject", "fitted", "measure"]

_RIM = 3            # samples at the raw frame's border that are not compared
# How OpenCV remaps a frame that a peer has demosaiced.
_REMAPPING = {"bilinear": cv2.INTER_LINEAR, "bicubic": cv2.INTER_CUBIC}
_CREST = f"{DIRECTIONAL.name}+crest"
FLOWS = (*INTERPOLATIONS, _CREST, *(f"{peer}, {way}" for peer in PEERS for way in _REMAPPING))


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
        The other figures are those of :meth:`.metrics.Reference.figures`, of the first reference.
        All are None if the flow is not installed.
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
    for peer in PEERS:
        colours = decoded(peer, raw, geometry.bayer)
        made |= {f"{peer}, {way}": None if colours is None else remap(colours, kernel)
                 for way, kernel in _REMAPPING.items()}
    low, high = (remap(each, cv2.INTER_NEAREST) for each in neighbours(subject.colour))
    reference = Reference(remap(subject.colour, cv2.INTER_LINEAR), low, high, mask)
    lanczos = remap(subject.colour, cv2.INTER_LANCZOS4)

    def row(picture):
        if picture is None:
            return dict.fromkeys((*FIGURES, "psnr_lanczos_db", "ssim"))
        return reference.figures(picture) | {
            "psnr_lanczos_db": psnr(picture, lanczos, mask),
            "ssim": ssim(picture, reference.colour, mask)}

    rows = [{"picture": subject.name, "flow": flow} | row(picture)
            for flow, picture in made.items()]
    return rows, {flow: np.floor(picture.astype(np.float32) + .5).astype(np.uint8)
                  for flow, picture in {"reference": reference.colour, **made}.items()
                  if picture is not None}
