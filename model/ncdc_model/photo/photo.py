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
        uint8, (height, width) of one channel or (height, width, 3) RGB, rows as the sensor sent
        them: whatever the file says of its orientation, nothing is turned.
    bayer : str, optional
        Filter pattern that the file declares, or ``MONO``; None: it declares none.
    lossy : bool
        Whether JPEG has smoothed the samples, as no raw frame of a colour sensor is.
    """
    image: np.ndarray
    bayer: str | None = None
    lossy: bool = False
