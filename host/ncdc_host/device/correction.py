"""The golden model's correction for frame after frame: the same integers, faster.

The colours between the samples depend on the frame alone, and are computed once for each frame.
Each pixel's address and fractions depend on the lens alone, and are computed once for each lens.
The sums are exact: the golden model adds the same products in another order. The directional
interpolation is no sum of samples with fixed weights: the golden model itself makes its pictures.
"""

import numpy as np

from ncdc_model.golden.corrector import check_raw, correct, window_bands
from ncdc_model.golden.picture import corner_colours
from ncdc_spec.interpolation import DIRECTIONAL

__all__ = ["Correction"]

_PIXELS = 1 << 14       # that are corrected at a time: what lies between takes little memory


class Correction:
    """Corrects raw frames of one descriptor, bit for bit as
    :func:`ncdc_model.golden.corrector.correct`.

    Parameters
    ----------
    descriptor : Descriptor

    Attributes
    ----------
    descriptor : Descriptor
    blank : ndarray
        True where the corrected pixel has no source, (height, width).
    """
    def __init__(self, descriptor):
        self.descriptor = descriptor
        f_bits, geometry = descriptor.formats.coordinate.f_bits, descriptor.geometry
        self._fixed_weights = geometry.mono or geometry.interpolation != DIRECTIONAL
        self._one, self._cut = 1 << f_bits, geometry.interpolation.cut(f_bits)
        self._shift = 2 * f_bits + geometry.interpolation.unit_bits - self._cut
        self._kernels = _coefficients(geometry)
        # The largest sum, of samples of 255 where the weights are positive or where they are not.
        largest = np.abs(self._kernels).sum(axis=(1, 2)).max() * 255
        self._type = np.int32 if largest << 2 * f_bits < 1 << 30 else np.int64
        margin = geometry.interpolation.margin
        self._row = geometry.distorted_width + 2 * margin - geometry.interpolation.window + 2
        bands = [band[1:] for band in window_bands(descriptor)]
        addresses = [y0 * self._row + x0 for x0, y0, *_ in bands]
        self._address = np.concatenate(addresses).ravel().astype(np.int32)
        self._fx, self._fy = (np.concatenate([band[k] for band in bands]).ravel().astype(np.uint16)
                              for k in (2, 3))
        self.blank = ~np.concatenate([band[-1] for band in bands])

    def __call__(self, raw, crest=0):
        """The corrected picture, uint8 RGB (height, width, 3), of a ``raw`` frame.

        ``crest``: as for :func:`ncdc_model.golden.corrector.correct`.

        Raises
        ------
        InputError
            If the frame is not of the descriptor's distorted size, or the interpolation has no
            crest.
        """
        if crest or not self._fixed_weights:
            return correct(self.descriptor, raw, crest=crest).picture
        geometry = self.descriptor.geometry
        check_raw(raw, geometry)
        colours = self._colours(raw).reshape(-1, 3)
        picture = np.empty((len(self._address), 3), np.uint8)
        for first in range(0, len(picture), _PIXELS):
            part = slice(first, first + _PIXELS)
            self._interpolate(colours, part, picture[part])
        picture = picture.reshape(*geometry.corrected[::-1], 3)
        picture[self.blank] = geometry.fill
        return picture

    def _colours(self, raw):
        """Colours between the samples at every address, by sums of the samples around it."""
        window = self._kernels.shape[1]
        # Samples outside the frame are mirrored, as the golden model mirrors them.
        framed = np.pad(raw, self.descriptor.geometry.interpolation.margin,
                        mode="reflect").astype(self._type)
        height = framed.shape[0] - window + 1
        colours = np.zeros((height, self._row, 3), self._type)
        for parity, kernel in enumerate(self._kernels):
            right, below = parity & 1, parity >> 1
            part = colours[below::2, right::2]
            for row, column, colour in zip(*kernel.nonzero()):
                at = framed[below + row:below + row + height - below:2,
                            right + column:right + column + self._row - right:2]
                part[..., colour] += kernel[row, column, colour].astype(self._type) * at
        return colours

    def _interpolate(self, colours, part, picture):
        """Write the pixels of a ``part`` to ``picture``."""
        address = self._address[part]
        fx, fy = (fraction[part, None].astype(self._type) for fraction in (self._fx, self._fy))
        upper, lower = (
            (self._one - fx) * colours[address + below] + fx * colours[address + below + 1]
            >> self._cut
            for below in (0, self._row))
        total = (self._one - fy) * upper + fy * lower
        total += 1 << (self._shift - 1)
        total >>= self._shift
        picture[:] = total.clip(0, 255)


def _coefficients(geometry):
    """Weights of the samples in the colours between them, by the golden model's decoder.

    Shape (parity, row, column, colour); ``parity``: of column and row, in bits 0 and 1.
    """
    window = geometry.interpolation.window
    unit = np.eye(window * window, dtype=np.int64).reshape(-1, window, window)
    tables = []
    for parity in range(4):
        x0, y0 = (np.full(len(unit), bit) for bit in (parity & 1, parity >> 1))
        first = corner_colours(unit, x0, y0, geometry)[0, 0]
        tables.append(first.T.reshape(window, window, 3)[:-1, :-1])
    return np.array(tables)
