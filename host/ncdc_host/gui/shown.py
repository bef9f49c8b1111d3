"""A frame made ready to be painted, which the receiving thread does."""

from dataclasses import dataclass

import numpy as np
from PySide6.QtGui import QImage

from ncdc_host.client.frame import Frame

__all__ = ["LEVELS", "Shown"]

LEVELS = 256


@dataclass(frozen=True)
class Shown:
    """A frame, its colours as a :class:`QImage`, and how often each grey level is in them.

    Parameters
    ----------
    frame : Frame
    image : QImage
        RGB; raw frames demosaiced.
    histogram : ndarray of int, shape (3, 256)
        Counts of red, green and blue as painted; of a raw frame, those of its colours' own samples.
    """
    frame: Frame
    image: QImage
    histogram: np.ndarray

    @classmethod
    def of(cls, frame):
        """``frame`` made ready."""
        picture = frame.picture()
        height, width = picture.shape[:2]
        # The copy is Qt's own: the picture's memory is gone after this.
        image = QImage(picture.data, width, height, 3 * width, QImage.Format.Format_RGB888).copy()
        return cls(frame, image.convertToFormat(QImage.Format.Format_RGB32), _histogram(frame))


def _histogram(frame):
    pixels = frame.pixels
    if frame.pixel_format.raw:
        samples_of = {colour: [] for colour in "RGB"}
        for k, colour in enumerate(frame.pixel_format.bayer):
            samples_of[colour].append(pixels[k // 2::2, k % 2::2].ravel())
        samples = [np.concatenate(samples_of[colour]) for colour in "RGB"]
    elif pixels.ndim == 2:
        samples = [pixels.ravel()] * 3
    else:
        samples = [np.ascontiguousarray(pixels[..., k]).ravel() for k in range(3)]
    return np.stack([np.bincount(one, minlength=LEVELS) for one in samples])
