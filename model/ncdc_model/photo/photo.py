"""A photo or raw frame in memory."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Photo"]


@dataclass(frozen=True)
class Photo:
    """A decoded file.

    Parameters
    ----------
    image : ndarray
        uint8, (height, width) of one channel or (height, width, 3) RGB, in the sensor's order of
        rows: the orientation in the file is ignored.
    bayer : str, optional
        Filter pattern declared in the file, or ``MONO``; None if there is none.
    lossy : bool
        Whether JPEG has smoothed the samples; a raw frame of a colour sensor is never lossy.
    """
    image: np.ndarray
    bayer: str | None = None
    lossy: bool = False
