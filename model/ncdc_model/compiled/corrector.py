"""Frames of one descriptor, corrected by the compiled model.

What depends on the lens and the view alone, the source of each pixel, is computed once.
"""

import ctypes
import threading

import numpy as np

from ncdc_model.compiled.library import library, pointer
from ncdc_spec.interpolation import DIRECTIONAL

__all__ = ["CompiledCorrector"]

_SOURCE = np.dtype([("corner", np.int32), ("fx", np.int32), ("fy", np.int32)])  # struct source


class _Blending(ctypes.Structure):
    """``struct blending`` of pictures.c."""
    _fields_ = [(name, ctypes.c_int32) for name in
                ("f_bits", "unit_bits", "cut", "width", "strength")]
    _fields_ += [("curvature", ctypes.c_void_p), ("fill", ctypes.c_uint8 * 4)]


class CompiledCorrector:
    """Corrects raw frames of a descriptor, bit for bit as
    :func:`ncdc_model.golden.corrector.correct`.

    Parameters
    ----------
    descriptor : Descriptor
    x, y, valid : ndarray, shape (height, width)
        Raw coordinates of each pixel, int32, and whether it is in a valid span, bool.

    Attributes
    ----------
    first : ndarray of int32, shape (height, width)
        Index y0 * distorted width + x0 of the first corner of each pixel; -1 where it is blank.

    Raises
    ------
    InputError
        If there is no compiled library, see :func:`ncdc_model.compiled.library.library`.
    """
    def __init__(self, descriptor, x, y, valid):
        self._geometry = geometry = descriptor.geometry
        self._f_bits = descriptor.formats.coordinate.f_bits
        self._sources = np.empty(valid.shape, _SOURCE)
        needs = geometry.interpolation
        library().sources(pointer(x), pointer(y), pointer(valid), valid.size,
                          int(needs.offset * (1 << self._f_bits)), self._f_bits, needs.core,
                          *geometry.distorted, *geometry.phase, pointer(self._sources))
        self.first = self._sources["corner"] >> 2
        self._lock = threading.Lock()       # of the arrays below
        self._arrays = {}       # of a frame: to get them anew takes a sixth of its time

    def picture(self, raw, crest=0):
        """The corrected picture, uint8 RGB (height, width, 3), of a ``raw`` frame of the distorted
        size.

        ``crest``: strength, 0 to 2; another interpolation than directional has none.
        """
        with self._lock:
            return self._picture(np.ascontiguousarray(raw), crest)

    def _picture(self, raw, crest):
        geometry, needs = self._geometry, self._geometry.interpolation
        framed = np.pad(raw, needs.margin, mode="reflect") if needs.margin else raw
        curvature = self._at_samples("curvatures", framed, 2) if crest else None
        blending = _Blending(self._f_bits, needs.unit_bits, needs.cut(self._f_bits),
                             geometry.distorted_width, crest,
                             None if curvature is None else pointer(curvature),
                             (*geometry.fill, 0))
        pixels = ctypes.byref(blending), pointer(self._sources), self.first.size
        picture = np.empty((*self.first.shape, 3), np.uint8)
        if geometry.mono:
            colours = self._at_samples("grey_colours", framed, 4)
            library().blend(*pixels, pointer(colours), pointer(picture))
        elif needs == DIRECTIONAL:
            terms = self._at_samples("directional_terms", framed, 4, *geometry.phase)
            direction = self._directions(framed)
            library().blend_directional(*pixels, pointer(terms), pointer(raw),
                                        pointer(direction), pointer(picture))
        else:
            colours = self._at_samples(f"{needs.name}_colours", framed, 4, *geometry.phase)
            library().blend(*pixels, pointer(colours), pointer(picture))
        return picture

    def _at_samples(self, function, framed, values, *phase):
        """So many int16 ``values`` at every sample of a frame, by a C ``function``."""
        width, height = self._geometry.distorted
        out = self._array(function, (height, width, values), np.int16)
        getattr(library(), function)(pointer(framed), width, height, *phase, pointer(out))
        return out

    def _directions(self, framed):
        """Twice the direction of the quad at every sample, int8."""
        width, height = self._geometry.distorted
        along, down = self._array("variations", (2, *framed.shape), np.uint8)
        out = self._array("directions", (height, width), np.int8)
        library().variations(pointer(framed), width, height, pointer(along), pointer(down))
        library().directions(pointer(along), pointer(down), width, height, pointer(out))
        return out

    def _array(self, name, shape, kind):
        """An array without values, the same one for every frame."""
        if name not in self._arrays:
            self._arrays[name] = np.empty(shape, kind)
        return self._arrays[name]
