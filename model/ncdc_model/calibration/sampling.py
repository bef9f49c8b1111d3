"""Samples a picture at lists of positions of any length."""

import cv2
import numpy as np

__all__ = ["bilinear", "sample"]

_BLOCK = 1 << 14       # positions per call: OpenCV takes less than 32,767 columns or rows


def sample(picture, positions, kernel=cv2.INTER_LINEAR):
    """Interpolated values of ``picture`` at ``positions``, clamped to the border.

    Parameters
    ----------
    picture : ndarray of uint8 or float32, shape (height, width)
        Less than 32,767 pixels on a side.
    positions : ndarray, shape (..., 2)
        x and y in pixels, any number of them.
    kernel : int
        OpenCV's interpolation.

    Returns
    -------
    ndarray of the type of ``picture``, shape (...)
    """
    positions = np.asarray(positions)
    flat, values = positions.reshape(-1, 2), np.empty(positions.size // 2, picture.dtype)
    for start in range(0, len(flat), _BLOCK):
        part = slice(start, start + _BLOCK)
        values[part] = cv2.remap(picture, flat[part].astype(np.float32)[None], None, kernel,
                                 borderMode=cv2.BORDER_REPLICATE)[0]
    return values.reshape(positions.shape[:-1])


def bilinear(picture, positions):
    """Values of ``picture`` at ``positions``, clamped to the border, in full precision.

    OpenCV counts positions in 32nds of a pixel.

    Parameters
    ----------
    picture : ndarray, shape (height, width)
    positions : ndarray, shape (..., 2)
        x and y in pixels.

    Returns
    -------
    ndarray of float32, shape (...)
    """
    limit = np.array(picture.shape[::-1]) - 1
    at = np.clip(np.nan_to_num(positions), 0, limit)
    first = np.minimum(at.astype(np.intp), np.maximum(limit - 1, 0))
    (a, b), (x, y) = np.moveaxis(at - first, -1, 0), np.moveaxis(first, -1, 0)
    right, down = np.minimum(x + 1, limit[0]), np.minimum(y + 1, limit[1])
    upper, lower = ((1 - a) * picture[row, x] + a * picture[row, right] for row in (y, down))
    return ((1 - b) * upper + b * lower).astype(np.float32)
