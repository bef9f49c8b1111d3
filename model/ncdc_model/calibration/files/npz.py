"""Cameras in NumPy's .npz, as OpenCV's tutorial writes them: mtx and dist."""

import zipfile
from io import BytesIO

import numpy as np

from ncdc_model.calibration.files.opencv import is_opencv, opencv_lens
from ncdc_model.calibration.files.unread import may_bend
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import MIN_SIZE

__all__ = ["holds_camera", "npz_lens"]

_LARGEST = 1 << 16     # bytes: a matrix, coefficients, a size; poses may be larger


def holds_camera(content):
    """Whether the .npz ``content`` holds a camera, and no map."""
    try:
        return not _tables(content) and is_opencv(_arrays(content))
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, NotImplementedError):
        return False


def npz_lens(content, camera=None):
    """:class:`FileLens` of the .npz ``content``.

    Raises
    ------
    InputError, KeyError, TypeError, ValueError
        As of :func:`~ncdc_model.calibration.files.opencv.opencv_lens`.
    """
    try:
        tables = {name: value.item() if value.ndim == 0 else value
                  for name, value in _arrays(content).items()}
        _check_skipped(content, tables)
    except (OSError, EOFError, zipfile.BadZipFile, NotImplementedError) as error:
        raise InputError(f"it is no .npz that can be read: {error}") from error
    return opencv_lens(tables, camera)


def _check_skipped(content, tables):
    """Reject a file with an array that may be distortion and is none of ``tables``."""
    with zipfile.ZipFile(BytesIO(content)) as archive:
        names = [name.removesuffix(".npy") for name in archive.namelist()]
    for name in names:
        if name not in tables and may_bend(name):
            raise InputError(f"{name} may be distortion, but is no array of at most {_LARGEST} "
                             f"bytes of numbers")


def _tables(content):
    """Whether the file holds an array of two dimensions that is as large as a map's."""
    with zipfile.ZipFile(BytesIO(content)) as archive:
        for name in archive.namelist():
            with archive.open(name) as file:
                version = np.lib.format.read_magic(file)
                read = (np.lib.format.read_array_header_1_0 if version == (1, 0)
                        else np.lib.format.read_array_header_2_0)
                shape = read(file)[0]
                if len(shape) == 2 and min(shape) >= MIN_SIZE:
                    return True
    return False


def _arrays(content):
    """Small arrays of numbers or text by name."""
    with zipfile.ZipFile(BytesIO(content)) as archive:
        small = [entry.filename.removesuffix(".npy") for entry in archive.infolist()
                 if entry.file_size <= _LARGEST]
    found = {}
    with np.load(BytesIO(content), allow_pickle=False) as tables:
        for name in small:
            try:
                value = tables[name]
            except ValueError:      # a Python list, as the poses of the tutorial
                continue
            if value.dtype.kind in "biufU":
                found[name] = value
    return found
