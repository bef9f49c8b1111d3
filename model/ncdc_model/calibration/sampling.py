"""Samples a picture at lists of places, however many."""

import cv2
import numpy as np

__all__ = ["sample"]

_BLOCK = 1 << 14       # places of one call: OpenCV takes less than 32,767 columns or rows


def sample(picture, places, kernel=cv2.INTER_LINEAR):
    """Values of ``picture`` at ``places``, interpolated; beyond the border those of the border.

    Parameters
    ----------
    picture : ndarray of uint8 or float32, shape (height, width)
        Less than 32,767 pixels on a side.
    places : ndarray, shape (..., 2)
        x and y in pixels, any number of them.
    kernel : int
        OpenCV's interpolation.

    Returns
    -------
    ndarray of the type of ``picture``, shape (...)
    """
    places = np.asarray(places)
    flat, values = places.reshape(-1, 2), np.empty(places.size // 2, picture.dtype)
    for start in range(0, len(flat), _BLOCK):
        part = slice(start, start + _BLOCK)
        values[part] = cv2.remap(picture, flat[part].astype(np.float32)[None], None, kernel,
                                 borderMode=cv2.BORDER_REPLICATE)[0]
    return values.reshape(places.shape[:-1])
