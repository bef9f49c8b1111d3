"""Colours at the samples themselves, without any map: means over sets of full-colour pictures."""

from pathlib import Path

import numpy as np

from ncdc_bench.pictures.conditions import CONDITIONS
from ncdc_bench.pictures.metrics import FIGURES, Reference, neighbours
from ncdc_bench.pictures.peers import PEERS, decoded
from ncdc_bench.pictures.synthetic import SYNTHETIC, synthetic_picture
from ncdc_model.golden.picture import bilinear, corner_colours, raw_windows
from ncdc_model.images import read_image
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MAX_SIZE, Geometry
from ncdc_spec.interpolation import DIRECTIONAL, FAST, INTERPOLATIONS

__all__ = ["on_grid", "pictures_of", "set_rows", "synthetic_rows"]

_BAYER = "RGGB"
_BORDER = 8             # samples left out on every side
_F_BITS = 10
_ROWS = 64              # of windows at a time: bounds the memory
_SUFFIXES = {".png", ".tif", ".tiff", ".bmp", ".jpg", ".jpeg"}


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
    # All four corners of a window are used, unless they depend on the window's direction.
    step = 1 if interpolation == DIRECTIONAL else 2
    for top in range(0, len(windows), _ROWS):
        band, part = picture[top:top + _ROWS], windows[top:top + _ROWS:step, ::step]
        y0, x0 = step * np.indices(part.shape[:2])
        corners = corner_colours(part, x0, y0 + top, geometry)
        for j, i in np.ndindex(step, step):
            chosen = band[j::step, i::step]
            rows, columns = chosen.shape[:2]
            chosen[:] = bilinear(corners[..., :rows, :columns], i << _F_BITS, j << _F_BITS, _F_BITS,
                                 interpolation)
    return picture


def _flows():
    """A function of the raw frame for each flow that has its colours at the samples.

    Crests are 0 there: ``directional+crest`` would be ``directional``.
    """
    ours = {name: lambda raw, each=each: on_grid(raw, each)
            for name, each in INTERPOLATIONS.items() if each != FAST}
    return ours | {peer: lambda raw, peer=peer: decoded(peer, raw, _BAYER) for peer in PEERS}


def _figures(colour, condition, flows):
    """Figures of one ``colour`` picture in a condition by flow; empty where one is missing."""
    # The last row and column are no first corner of a window.
    inner = tuple(slice(_BORDER, size - 1 - _BORDER) for size in colour.shape[:2])
    truth = condition.truth(colour)[inner]
    reference = Reference(truth, *neighbours(truth), np.ones(truth.shape[:2], bool))
    raw = condition.raw(colour, _BAYER, np.random.default_rng(1))
    made = {flow: decode(raw) for flow, decode in flows.items()}
    return {flow: {} if each is None else reference.figures(condition.shown(each[inner]))
            for flow, each in made.items()}


def _rows(name, pictures, conditions):
    """Rows of a set: for each condition, each flow's mean over ``pictures``, an iterable."""
    flows = _flows()
    found = [[_figures(colour, condition, flows) for condition in conditions]
             for colour in pictures]
    return [{"set": name, "pictures": len(found), "flow": flow, "noise": condition.noise,
             "gains": list(condition.gains), "balanced_first": condition.balanced_first,
             "linear": condition.linear, **_mean([figures[k][flow] for figures in found])}
            for k, condition in enumerate(conditions) for flow in flows]


def _mean(figures):
    """Mean of each figure, None where there is none."""
    return {name: float(np.mean([each[name] for each in figures])) if figures[0] else None
            for name in FIGURES}


def synthetic_rows(conditions=CONDITIONS, progress=lambda name: None):
    """Rows of the set ``synthetic``, as of :func:`set_rows`."""
    def pictures():
        for name in SYNTHETIC:
            progress(name)
            yield synthetic_picture(name)
    return _rows("synthetic", pictures(), conditions)


def set_rows(folder, conditions=CONDITIONS, progress=lambda name: None):
    """Rows of the pictures in a folder: for each condition, each flow's mean over them.

    Returns
    -------
    list of dict
        ``set``, the folder's name; ``pictures``, how many; ``flow``; ``noise``, ``gains``,
        ``balanced_first``, ``linear`` of the condition; means of the figures of
        :meth:`.metrics.Reference.figures`, None if the flow is not installed.

    Raises
    ------
    InputError
        If there is no picture, or one has no colour or is too large.
    """
    def pictures():
        for path in pictures_of(folder):
            progress(path.name)
            colour = read_image(path)
            if colour.ndim != 3 or max(colour.shape[:2]) > MAX_SIZE:
                raise InputError(f"{path} has the shape {colour.shape}, a colour picture of at "
                                 f"most {MAX_SIZE} pixels on a side is needed")
            yield colour
    return _rows(Path(folder).name, pictures(), conditions)
