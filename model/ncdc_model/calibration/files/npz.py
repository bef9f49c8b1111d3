"""Cameras in NumPy's .npz, as the tutorial of OpenCV keeps them: mtx and dist."""

import zipfile
from io import BytesIO

import numpy as np

from ncdc_model.calibration.files.opencv import is_opencv, opencv_lens

__all__ = ["holds_camera", "npz_lens"]

_LARGEST = 1 << 16     # bytes: a matrix, coefficients, a size; maps and poses are larger
_NOT = "rvecs", "tvecs"


def holds_camera(content):
    """Whether the .npz ``content`` holds a camera, and no map."""
    try:
        tables = _arrays(content)
    except (ValueError, OSError, EOFError, zipfile.BadZipFile, NotImplementedError):
        return False
    return tables is not None and is_opencv(tables)


def npz_lens(content, camera=None):
    """:class:`FileLens` of the .npz ``content``.

    Raises
    ------
    InputError, KeyError, TypeError, ValueError
        As of :func:`~ncdc_model.calibration.files.opencv.opencv_lens`.
    """
    tables = {name: value.item() if value.ndim == 0 else value
              for name, value in _arrays(content).items()}
    return opencv_lens(tables, camera)


def _arrays(content):
    """Small arrays of numbers or text by name; None if there are large ones, as those of maps."""
    with zipfile.ZipFile(BytesIO(content)) as archive:
        sizes = {entry.filename.removesuffix(".npy"): entry.file_size
                 for entry in archive.infolist()}
    if any(size > _LARGEST for name, size in sizes.items() if name.lower().startswith("map")):
        return None
    found = {}
    with np.load(BytesIO(content), allow_pickle=False) as tables:
        for name, size in sizes.items():
            if size <= _LARGEST and name not in _NOT:
                try:
                    value = tables[name]
                except ValueError:      # a list of Python's, as the poses of the tutorial
                    continue
                if value.dtype.kind in "biufU":
                    found[name] = value
    return found
