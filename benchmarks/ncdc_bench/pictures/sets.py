"""Colours at the samples themselves, without any map: means over sets of full-colour pictures."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ncdc_model.golden.picture import bilinear, corner_colours, raw_windows
from ncdc_model.images import demosaic, mosaic, read_image
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE, Geometry
from ncdc_spec.interpolation import FAST, INTERPOLATIONS

__all__ = ["CONDITIONS", "Condition", "on_grid", "pictures_of", "set_rows"]

_BAYER = "RGGB"
_BORDER = 8             # samples left out on every side
_F_BITS = 10
_ROWS = 64              # of windows at a time: bounds the memory
_SUFFIXES = {".png", ".tif", ".tiff", ".bmp", ".jpg", ".jpeg"}


@dataclass(frozen=True)
class Condition:
    """How a sensor sees a picture.

    Parameters
    ----------
    noise : float
        Standard deviation of normal noise, in grey levels.
    gains : tuple of float
        Sensitivity for red, green and blue; the colours are divided by it after decoding.
    balanced_first : bool
        Whether the samples are divided by it instead, before decoding.
    """
    noise: float = 0.0
    gains: tuple = (1.0, 1.0, 1.0)
    balanced_first: bool = False


_UNBALANCED = (0.5, 1.0, 0.6)
CONDITIONS = (Condition(), *(Condition(noise=sigma) for sigma in (2.0, 5.0, 10.0)),
              Condition(gains=_UNBALANCED), Condition(gains=_UNBALANCED, balanced_first=True))


def pictures_of(folder):
    """Paths of the pictures in a folder.

    Raises
    ------
    InputError
        If there is none.
    """
    found = sorted(path for path in Path(folder).iterdir() if path.suffix.lower() in _SUFFIXES) \
        if Path(folder).is_dir() else []
    if not found:
        raise InputError(f"{folder} has no picture, a folder of {', '.join(sorted(_SUFFIXES))} is "
                         f"needed")
    return found


def on_grid(raw, interpolation):
    """Colours (height - 1, width - 1, 3) uint8 at the samples of a ``raw`` RGGB frame."""
    height, width = raw.shape
    geometry = Geometry(8, 8, width, height, bayer=_BAYER, interpolation=interpolation)
    windows = raw_windows(raw, interpolation)
    picture = np.empty((*windows.shape[:2], 3), np.uint8)
    for top in range(0, len(windows), _ROWS):
        part = windows[top:top + _ROWS]
        y0, x0 = np.indices(part.shape[:2])
        corners = corner_colours(part, x0, y0 + top, geometry)
        picture[top:top + _ROWS] = bilinear(corners, 0, 0, _F_BITS, interpolation)
    return picture


def _flows():
    """A function of the raw frame for each flow that has its colours at the samples."""
    ours = {name: lambda raw, each=each: on_grid(raw, each)
            for name, each in INTERPOLATIONS.items() if each != FAST}
    return ours | {f"opencv {name}": lambda raw, name=name: demosaic(raw, _BAYER, name)
                   for name in ("bilinear", "edge-aware", "vng")}


def _seen(colour, condition, rng):
    """The raw frame of a ``colour`` picture, and by what its colours are to be divided."""
    gains = np.array(condition.gains)
    samples = mosaic(colour * gains, _BAYER) + condition.noise * rng.standard_normal(
        colour.shape[:2])
    raw = np.clip(np.floor(samples + .5), 0, 255)
    if condition.balanced_first:
        balance = mosaic(np.broadcast_to(gains, colour.shape), _BAYER)
        raw, gains = np.clip(np.floor(raw / balance + .5), 0, 255), np.ones(3)
    return raw.astype(np.uint8), gains


def set_rows(folder, conditions=CONDITIONS, progress=lambda name: None):
    """Rows of the pictures in a folder: for each condition, each flow's mean over them.

    Returns
    -------
    list of dict
        ``set``, the folder's name; ``pictures``, how many; ``flow``; ``noise``, ``gains``,
        ``balanced_first`` of the condition; ``psnr_db``: mean of the peak signal-to-noise ratios
        over all three colours.

    Raises
    ------
    InputError
        If there is no picture, or one has no colour or is too large.
    """
    paths, flows = pictures_of(folder), _flows()
    found = {(condition, flow): [] for condition in conditions for flow in flows}
    inner = (slice(_BORDER, -_BORDER),) * 2
    for path in paths:
        progress(path.name)
        colour = read_image(path)
        if colour.ndim != 3 or max(colour.shape[:2]) > MAX_SIZE:
            raise InputError(f"{path} has the shape {colour.shape}, a colour picture of at most "
                             f"{MAX_SIZE} pixels on a side is needed")
        for condition in conditions:
            raw, gains = _seen(colour, condition, np.random.default_rng(1))
            for flow, decode in flows.items():
                decoded = decode(raw) / gains
                error = (decoded[:raw.shape[0] - 1, :raw.shape[1] - 1].clip(0, 255)
                         - colour[:-1, :-1])[inner]
                found[condition, flow].append(10 * np.log10(255**2 / np.mean(error**2)))
    return [{"set": Path(folder).name, "pictures": len(paths), "flow": flow,
             "noise": condition.noise, "gains": list(condition.gains),
             "balanced_first": condition.balanced_first, "psnr_db": float(np.mean(values))}
            for (condition, flow), values in found.items()]
