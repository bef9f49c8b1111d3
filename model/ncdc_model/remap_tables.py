"""The map of a descriptor as tables for OpenCV's ``remap``."""

from pathlib import Path

import cv2
import numpy as np

from ncdc_model.correction import correction_of, frame_coordinates
from ncdc_spec.errors import InputError
from ncdc_spec.files import replace_file

__all__ = ["SUFFIXES", "remap_tables", "save_tables"]

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
