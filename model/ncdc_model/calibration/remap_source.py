"""Tables for OpenCV's ``remap`` as the exact map of a corrected frame."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_model.calibration.remap_checks import (
    check_finite,
    check_meaning,
    check_smooth,
    folded_warning,
    sensor_warning,
)
from ncdc_model.calibration.remap_file import read_remap
from ncdc_model.golden.valid import valid_mask
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import Geometry

__all__ = ["RemapMap", "load_remap"]


@dataclass(frozen=True)
class RemapMap:
    """Source pixel of every corrected pixel.

    Parameters
    ----------
    x, y : ndarray of float64, shape (height, width)
        Not-a-number where the corrected pixel is not valid, see
        :func:`~ncdc_model.golden.valid.valid_mask`.
    geometry : Geometry
    model : str
        Format of the tables, for reports.
    digest : str
        Twelve hex digits of the hash of the files.
    warnings : tuple of str
        What is odd about the map.
    """
    x: np.ndarray
    y: np.ndarray
    geometry: Geometry
    model: str
    digest: str
    warnings: tuple = ()

    def back_map(self, u, v):
        """(x, y) of corrected pixels inside the frame, linear between whole pixels."""
        u, v = np.asarray(u, np.float64), np.asarray(v, np.float64)
        column, row = np.floor(u).astype(np.int64), np.floor(v).astype(np.int64)
        right = np.minimum(column + 1, self.x.shape[1] - 1)
        below = np.minimum(row + 1, self.x.shape[0] - 1)
        return tuple(_between(_between(table[row, column], table[row, right], u - column),
                              _between(table[below, column], table[below, right], u - column),
                              v - row) for table in (self.x, self.y))

    @property
    def reach(self):
        """Smallest and largest source column, and row, as two pairs."""
        return tuple((float(np.nanmin(table)), float(np.nanmax(table)))
                     for table in (self.x, self.y))


def _between(a, b, part):
    # A pixel without a source must not affect an exact result at the next pixel.
    return np.where(part == 0, a, a + part * (b - a))


def load_remap(paths, sensor=None, camera=None, **options):
    """Read and check remap tables.

    Parameters
    ----------
    paths : sequence of path
        One file, or the two of x and y.
    sensor : (int, int), optional
        Width and height of the distorted image, if the file does not state it.
    camera : str, optional
        Which of several maps in the file.
    options
        ``bayer``, ``fill`` and ``interpolation`` of :class:`Geometry`.

    Returns
    -------
    RemapMap

    Raises
    ------
    InputError
        If the files are bad, the sensor's size is not known, or the tables are no smooth map of
        source pixels in it.
    """
    file, subject = read_remap(paths, camera), " and ".join(map(str, paths))
    if sensor is None and file.sensor is None:
        raise InputError(f"{subject}: the size of the sensor is not known; --sensor-size WxH gives "
                         f"it, or in the file the two numbers `sensor`")
    if None not in (sensor, file.sensor) and tuple(sensor) != file.sensor:
        raise InputError("the sensor has {}x{} pixels, ".format(*sensor)
                         + "the map of {} is for {}x{}".format(subject, *file.sensor))
    try:
        return _checked(file, Geometry(*file.x.shape[::-1], *(sensor or file.sensor), **options))
    except InputError as error:
        raise InputError(f"{subject}: {error}") from error


def _marked(x, y):
    """The tables with -1 where they hold (0, 0), if several pixels do.

    No two pixels of a smooth map have the same source: zero then marks pixels without one. It would
    be taken for the first sample of the sensor.
    """
    zero = (x == 0) & (y == 0)
    if zero.sum() < 2:
        return x, y
    return np.where(zero, -1, x), np.where(zero, -1, y)


def _checked(file, geometry):
    check_finite(file.names, (file.x, file.y))
    x, y = _marked(file.x, file.y)
    check_meaning(x, y, geometry)
    inside = geometry.window_inside(x, y)
    draft = RemapMap(np.where(inside, x, np.nan), np.where(inside, y, np.nan), geometry,
                     file.kind, file.digest)
    valid = valid_mask(draft.back_map, geometry)
    warnings = (check_smooth(x, y, inside, valid), folded_warning(inside, valid),
                sensor_warning(x, y, inside, geometry))
    return replace(draft, x=np.where(valid, x, np.nan), y=np.where(valid, y, np.nan),
                   warnings=tuple(filter(None, warnings)))
