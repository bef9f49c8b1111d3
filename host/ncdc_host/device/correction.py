"""The golden model's correction as one sparse matrix: the same integers, much faster.

A corrected colour is a sum of at most 9 raw samples with whole weights, with the gradient-corrected
interpolation of at most 36, rounded and clamped once: the golden model adds the same products in
another order. The sums fit the matrix's integers, so they are exact.
"""

import numpy as np
from scipy.sparse import csr_array, vstack

from ncdc_model.corrector import check_raw, window_bands
from ncdc_model.picture import place_colours

__all__ = ["Correction"]


class Correction:
    """Corrects raw frames of one descriptor, bit for bit as :func:`ncdc_model.corrector.correct`.

    Parameters
    ----------
    descriptor : Descriptor

    Attributes
    ----------
    descriptor : Descriptor
    """
    def __init__(self, descriptor):
        self.descriptor = descriptor
        f_bits, geometry = descriptor.formats.coordinate.f_bits, descriptor.geometry
        self._shift = 2 * f_bits + geometry.interpolation.unit_bits
        coefficients = _coefficients(geometry)
        # The largest sum, of samples of 255 where the weights are positive or where they are not.
        largest = (np.abs(coefficients).sum(axis=1).max() * 255) << (2 * f_bits)
        self._type = np.int32 if largest < 1 << 30 else np.int64
        parts = list(window_bands(descriptor))
        self._blank = ~np.concatenate([part[-1] for part in parts])
        self._matrix = vstack([_band(descriptor, part, coefficients, self._type)
                               for part in parts], "csr")

    def __call__(self, raw):
        """The corrected picture, uint8 RGB (height, width, 3), of a ``raw`` frame.

        Raises
        ------
        InputError
            If the frame is not of the descriptor's distorted size.
        """
        geometry = self.descriptor.geometry
        check_raw(raw, geometry)
        total = self._matrix @ raw.ravel().astype(self._type)
        total += 1 << (self._shift - 1)
        total >>= self._shift
        picture = total.clip(0, 255).astype(np.uint8).reshape(*geometry.corrected[::-1], 3)
        picture[self._blank] = geometry.fill
        return picture


def _coefficients(geometry):
    """Weight of each window sample in each place: (parity, sample, j, i, colour), by the decoder.

    ``parity``: of column and row of the first place, in bits 0 and 1.
    """
    window = geometry.interpolation.window
    unit = np.eye(window * window, dtype=np.int64).reshape(-1, window, window)
    tables = []
    for parity in range(4):
        x0, y0 = (np.full(len(unit), bit) for bit in (parity & 1, parity >> 1))
        tables.append(np.moveaxis(place_colours(unit, x0, y0, geometry), -1, 0))
    return np.array(tables)


def _band(descriptor, band, coefficients, dtype):
    """The rows of the matrix of a band of :func:`window_bands`, three to a pixel."""
    geometry, f_bits = descriptor.geometry, descriptor.formats.coordinate.f_bits
    width, height = geometry.distorted
    _, x0, y0, fx, fy, _ = (a if isinstance(a, slice) else a.ravel() for a in band)
    one = 1 << f_bits
    across, down = np.stack([one - fx, fx]), np.stack([one - fy, fy])
    # (pixel, colour, sample): the bilinear weights of the places that the sample is part of.
    weights = np.einsum("nkjic,jn,in->nck", coefficients[x0 & 1 | (y0 & 1) << 1], down, across)
    # Samples outside the frame are mirrored, as the golden model mirrors them.
    framed = np.pad(np.arange(width * height, dtype=np.int32).reshape(height, width),
                    geometry.interpolation.margin, mode="reflect")
    row, column = np.divmod(np.arange(weights.shape[2]), geometry.interpolation.window)
    place = framed[y0[:, None] + row, x0[:, None] + column]
    used = weights != 0
    starts = np.concatenate([[0], np.cumsum(used.sum(axis=2).ravel())])
    columns = np.broadcast_to(place[:, None, :], weights.shape)[used]
    return csr_array((weights[used].astype(dtype), columns, starts.astype(np.int32)),
                     shape=(3 * len(x0), width * height))
