"""Samples a picture at lists of positions of any length."""

import cv2
import numpy as np

__all__ = ["sample"]

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
