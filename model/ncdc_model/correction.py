"""Corrected frames by the compiled model, or by the golden one where there is no C compiler.

Both give the same bits. What depends on the lens alone is computed once for each descriptor.
"""

import os
from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import cv2
import numpy as np

from ncdc_model.compiled import coordinates as compiled
from ncdc_model.compiled.corrector import CompiledCorrector
from ncdc_model.compiled.library import library
from ncdc_model.compiled.view import view_sources
from ncdc_model.golden import colour as golden_colour
from ncdc_model.golden import corrector as golden
from ncdc_model.golden import network
from ncdc_model.golden.corrector import Corrected, check_raw, window_bands
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import scan_order
from ncdc_spec.interpolation import check_crest
from ncdc_spec.raw_gains import NO_RAW_GAINS, balanced_raw

__all__ = ["COMPILED", "Correction", "MODELS", "REFERENCE", "correct", "correction_of",
           "coloured", "default_model", "frame_coordinates"]

COMPILED, REFERENCE = "compiled", "reference"
MODELS = (COMPILED, REFERENCE)

_LENSES = 4             # that stay: 12 bytes a pixel each
_ROWS = 64              # corrected rows at a time: bounds the memory


def default_model(warn=lambda sentence: None):
    """The model that ``NCDC_MODEL`` names, or the compiled one, or the reference if that cannot be
    had: then ``warn`` is called with a sentence.

    Raises
    ------
    InputError
        If ``NCDC_MODEL`` names none.
    """
    if chosen := os.environ.get("NCDC_MODEL"):
        if chosen not in MODELS:
            raise InputError(f"NCDC_MODEL is {chosen!r}, one of {', '.join(MODELS)} is needed")
        return chosen
    try:
        library()
    except InputError as error:
        warn(f"the reference model is used, which takes a hundred times as long: {error}")
        return REFERENCE
    return COMPILED


class Correction:
    """Corrects raw frames of one descriptor.

    Parameters
    ----------
    descriptor : Descriptor
    model : str, optional
        One of :data:`MODELS`; :func:`default_model` by default.
    view : View, optional
        What the corrected frames show; the trained picture by default.

    Raises
    ------
    InputError
        If the compiled model is asked for and cannot be had, or there is a view and no nodes.
    """
    def __init__(self, descriptor, model=None, view=None):
        self.descriptor, self.view = descriptor, view
        self.model = model or default_model()
        self._compiled = (CompiledCorrector(descriptor, *_frame_sources(descriptor, view))
                          if self.model == COMPILED else None)
        self._fetches = {}      # by the width of strips

    def __call__(self, raw, crest=0, strip=0, progress=lambda done, total: None,
                 raw_gains=NO_RAW_GAINS):
        """The :class:`~ncdc_model.golden.corrector.Corrected` frame of a ``raw`` one.

        See :func:`ncdc_model.golden.corrector.correct`.
        """
        if self._compiled is None:
            return golden.correct(self.descriptor, raw, progress, strip, crest, raw_gains,
                                  self.view)
        geometry = self.descriptor.geometry
        check_raw(raw, geometry)
        check_crest(crest, geometry.interpolation)
        picture = self._compiled.picture(balanced_raw(raw, geometry, raw_gains), crest)
        progress(len(picture), len(picture))
        return Corrected(picture, self.blank, self._fetches_of(strip))

    @cached_property
    def blank(self):
        """Pixels without a source: bool (height, width), not to be written."""
        blank = ~self.corners()[2] if self._compiled is None else self._compiled.first < 0
        blank.flags.writeable = False
        return blank

    def corners(self, progress=lambda done, total: None):
        """First corner of the interpolation of each pixel: x0, y0, used, (height, width) each.

        x0 and y0 are int16, and zero where the pixel is blank and ``used`` is false.
        """
        width, height = self.view.size if self.view else self.descriptor.geometry.corrected
        if self._compiled is not None:
            used = ~self.blank
            y0, x0 = np.divmod(np.where(used, self._compiled.first, 0),
                               self.descriptor.geometry.distorted_width)
            progress(height, height)
            return x0.astype(np.int16), y0.astype(np.int16), used
        x0, y0 = np.zeros((2, height, width), np.int16)
        used = np.empty((height, width), bool)
        for rows, columns, lines, _, _, valid in window_bands(self.descriptor, self.view):
            used[rows] = valid
            x0[rows], y0[rows] = columns * valid, lines * valid
            progress(rows.stop, height)
        return x0, y0, used

    def _fetches_of(self, strip):
        """Windows that ``multiport`` reads, as of :func:`ncdc_model.golden.picture.fetches`."""
        if strip not in self._fetches:
            first = scan_order(self._compiled.first, strip)
            first = first[first >= 0]
            self._fetches[strip] = int(bool(first.size)) + int(np.count_nonzero(np.diff(first)))
        return self._fetches[strip]


@dataclass(frozen=True)
class _Lens:
    """A descriptor that equals others of its digest."""
    digest: str
    descriptor: Descriptor = field(compare=False)


@lru_cache(maxsize=_LENSES)
def _cached(lens, model, view):
    return Correction(lens.descriptor, model, view)


def correction_of(descriptor, model=None, view=None):
    """The :class:`Correction` of a descriptor and a view, one of the last few or a new one."""
    return _cached(_Lens(descriptor.digest, descriptor), model or default_model(), view)


def correct(descriptor, raw, progress=lambda done, total: None, strip=0, crest=0,
            raw_gains=NO_RAW_GAINS, model=None, view=None):
    """Correct a ``raw`` frame, see :func:`ncdc_model.golden.corrector.correct`.

    ``model``: as of :class:`Correction`.
    """
    return correction_of(descriptor, model, view)(raw, crest, strip, progress, raw_gains)


def frame_coordinates(descriptor):
    """Raw (x', y') of the whole corrected frame, int32 of shape (2, height, width).

    See :func:`ncdc_model.golden.network.coordinates`.
    """
    if default_model() == COMPILED:
        return compiled.frame_coordinates(descriptor)
    width, height = descriptor.geometry.corrected
    frame = np.empty((2, height, width), np.int32)
    for top in range(0, height, _ROWS):
        v, u = np.mgrid[top:min(top + _ROWS, height), 0:width]
        frame[:, top:top + _ROWS] = network.coordinates(descriptor, u, v)
    return frame


def _frame_sources(descriptor, view):
    """Arrays of :class:`CompiledCorrector`: raw coordinates of every pixel, and the valid ones."""
    if not view:
        return *frame_coordinates(descriptor), descriptor.valid.mask(
            descriptor.geometry.corrected_width)
    return view_sources(descriptor, view)


def coloured(corrected, colour, model=None):
    """The picture of a ``corrected`` frame after ``colour``.

    See :func:`ncdc_model.golden.colour.coloured`, which makes a table of all values for the
    compiled model. ``model``: as of :class:`Correction`.
    """
    if (model or default_model()) == REFERENCE:
        return golden_colour.coloured(corrected, colour)
    every = np.repeat(np.arange(256, dtype=np.uint8), 3).reshape(1, 256, 3)
    table = golden_colour.coloured(Corrected(every, np.zeros((1, 256), bool), 0), colour)
    picture = cv2.LUT(corrected.picture, table)
    return cv2.copyTo(corrected.picture, corrected.blank.view(np.uint8), picture)
