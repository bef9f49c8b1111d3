"""The map of a descriptor as tables for OpenCV's ``remap``; those of the planes of a film."""

from pathlib import Path

import cv2
import numpy as np

from ncdc_model.correction import correction_of, frame_coordinates
from ncdc_spec.errors import InputError
from ncdc_spec.files import replace_file

__all__ = ["SUFFIXES", "PlaneMaps", "remap_tables", "save_tables"]

SUFFIXES = (".npz", ".yml", ".yaml", ".xml", ".json")
# Far enough outside for the border colour with any interpolation.
_NOWHERE = -16.0


def remap_tables(descriptor):
    """Source pixel (map_x, map_y) of every corrected pixel, float32 (height, width).

    They are the integer network's coordinates, as in the hardware, without loss. Pixels that the
    hardware leaves blank have -16: ``cv2.remap`` gives them the border colour.
    """
    blank = correction_of(descriptor).blank
    scale = 2.0**-descriptor.formats.coordinate.f_bits
    return tuple(np.where(blank, _NOWHERE, raw * scale).astype(np.float32)
                 for raw in frame_coordinates(descriptor))


def save_tables(path, map_x, map_y, sensor):
    """Write the arrays map_x and map_y: NumPy (.npz) or OpenCV's FileStorage, by suffix.

    ``sensor``: width and height of the distorted image, written as the array sensor.

    Raises
    ------
    InputError
        If the suffix is none of :data:`SUFFIXES`, or the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in SUFFIXES:
        raise InputError(f"{path}: tables are written as one of {', '.join(SUFFIXES)}")
    with replace_file(path) as temporary:
        if suffix == ".npz":
            np.savez_compressed(temporary, map_x=map_x, map_y=map_y, sensor=sensor)
            return
        storage = cv2.FileStorage(str(temporary), cv2.FILE_STORAGE_WRITE)
        storage.write("map_x", map_x)
        storage.write("map_y", map_y)
        storage.write("sensor", np.array([sensor], np.int32))
        storage.release()


class PlaneMaps:
    """Remaps the planes of a picture, those of colour on their own coarser grid.

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
        VP9 and AV1 take it to be unless a tag says otherwise.
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
