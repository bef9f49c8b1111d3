"""Remaps the planes of a picture, those of colour on their own coarser grid."""

import cv2
import numpy as np

__all__ = ["PlaneMaps"]


class PlaneMaps:
    """The map of a picture for each of its planes.

    Parameters
    ----------
    map_x, map_y : ndarray of float32, shape (height, width)
        Source pixel of each pixel.
    blank : ndarray of bool, shape (height, width)
        Pixels without a source.
    kernel : int
        Interpolation of OpenCV.
    """

    def __init__(self, map_x, map_y, blank, kernel):
        self._kernel = kernel
        self._maps = {(1, 1): (map_x, map_y, blank)}

    def __call__(self, planes, fills):
        """The remapped ``planes``; each has its sample of ``fills`` where there is no source."""
        made = []
        for plane, fill in zip(planes, fills, strict=True):
            map_x, map_y, blank = self._reduced(*(
                round(whole / part) for whole, part in zip(planes[0].shape[:2], plane.shape)))
            found = cv2.remap(plane, map_x, map_y, self._kernel, borderMode=cv2.BORDER_REPLICATE)
            found[blank] = fill
            made.append(found)
        return made

    def _reduced(self, rows, columns):
        """The map of a plane with a sample for so many ``rows`` and ``columns`` of pixels.

        A sample lies on the first of its columns, and between its two rows: where H.264, H.265,
        VP9 and AV1 take it to be unless they are told otherwise.
        """
        if (rows, columns) not in self._maps:
            map_x, map_y, blank = (part[:, ::columns] for part in self._maps[1, 1])
            last = rows - 1
            above, below = blank[::rows], blank[last::rows]
            # Beside a pixel without a source, the other one's source counts.
            map_x, map_y = (
                np.where(above, part[last::rows], np.where(
                    below, part[::rows], (part[::rows] + part[last::rows]) / 2))
                for part in (map_x, map_y))
            self._maps[rows, columns] = (map_x / columns, (map_y - last / 2) / rows, above & below)
        return self._maps[rows, columns]
