"""The golden model's correction as one sparse matrix: the same integers, 50 times as fast.

A corrected colour is a sum of at most 9 raw samples with whole weights, rounded once: the golden
model adds the same products in another order. Its sums stay below 2**31, so that they are exact.
"""

import numpy as np
from scipy.sparse import csr_array, vstack

from ncdc_model.corrector import check_raw, window_bands
from ncdc_model.geometry import WINDOW
from ncdc_model.picture import bayer_quads

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
        f_bits = descriptor.formats.coordinate.f_bits
        self._shift = 2 * f_bits + 1
        # 255 * 2 * 2**(2 f_bits) is the largest sum.
        self._type = np.int32 if self._shift + 8 < 31 else np.int64
        parts = list(window_bands(descriptor))
        self._blank = ~np.concatenate([part[-1] for part in parts])
        self._matrix = vstack([_band(descriptor, part, self._type) for part in parts], "csr")

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
        picture = total.astype(np.uint8).reshape(*geometry.corrected[::-1], 3)
        picture[self._blank] = geometry.fill
        return picture


def _coefficients():
    """Weight of each window sample in each quad: (phase, sample, j, i, colour), by the decoder."""
    unit = np.eye(WINDOW * WINDOW, dtype=np.int64).reshape(-1, WINDOW, WINDOW)
    tables = []
    for phase in range(4):
        quads = bayer_quads(unit, np.zeros(len(unit), np.int64), np.zeros(len(unit), np.int64),
                            (phase & 1, phase >> 1))
        tables.append(np.moveaxis(quads, -1, 0))
    return np.array(tables)


_COEFFICIENTS = _coefficients()


def _band(descriptor, band, dtype):
    """The rows of the matrix of a band of :func:`window_bands`, three to a pixel."""
    geometry, f_bits = descriptor.geometry, descriptor.formats.coordinate.f_bits
    _, x0, y0, fx, fy, _ = (a if isinstance(a, slice) else a.ravel() for a in band)
    one = 1 << f_bits
    phase = (x0 + geometry.phase[0]) & 1 | ((y0 + geometry.phase[1]) & 1) << 1
    across, down = np.stack([one - fx, fx]), np.stack([one - fy, fy])
    # (pixel, colour, sample): the bilinear weights of the quads that the sample is part of.
    weights = np.einsum("nkjic,jn,in->nck", _COEFFICIENTS[phase], down, across)
    samples = np.arange(WINDOW * WINDOW)
    place = (y0[:, None] + samples // WINDOW) * geometry.distorted_width \
        + x0[:, None] + samples % WINDOW
    used = weights != 0
    starts = np.concatenate([[0], np.cumsum(used.sum(axis=2).ravel())])
    columns = np.broadcast_to(place[:, None, :], weights.shape)[used]
    shape = (3 * len(x0), geometry.distorted_width * geometry.distorted_height)
    return csr_array((weights[used].astype(dtype), columns.astype(np.int32),
                      starts.astype(np.int32)), shape=shape)
