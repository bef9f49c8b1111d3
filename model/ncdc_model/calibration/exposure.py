"""Finds overexposed boards: clipped white widens beyond the edges."""

from dataclasses import replace

import numpy as np

__all__ = ["with_exposure"]

_WHITE = 254           # grey level of a clipped pixel
_CLIPPED = 0.2         # of the samples, half of which are on white squares
_SAMPLES = np.array([(0.5, 0.5), (0.2, 0.5), (0.8, 0.5), (0.5, 0.2), (0.5, 0.8)])   # of a square


def with_exposure(image, photo):
    """``photo``, PhotoPoints of a chessboard in the uint8 ``image``, with a warning if more than a
    fifth of its squares, or two fifths of the white ones, are clipped."""
    position = {tuple(key): point for key, point in zip(photo.index.tolist(), photo.xy)}
    cells = [[position.get(key) for key in ((i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1))]
             for i, j in position]
    cells = np.array([cell for cell in cells if all(corner is not None for corner in cell)])
    if not len(cells):
        return photo
    u, v = _SAMPLES.T
    weights = np.stack([(1 - u) * (1 - v), u * (1 - v), (1 - u) * v, u * v])
    x, y = np.rint(np.einsum("ck,ncd->nkd", weights, cells)).astype(int).reshape(-1, 2).T
    clipped = float((image[y, x].reshape(len(x), -1).min(axis=1) >= _WHITE).mean())
    if clipped <= _CLIPPED:
        return photo
    return replace(photo, warnings=(*photo.warnings, (
        f"{200 * clipped:.0f} % of the white squares are as bright as can be: overexposed, their "
        f"edges move, and points may be off by a pixel")))
