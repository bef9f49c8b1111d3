"""Cameras of mrcal: .cameramodel files with one of OpenCV's lens models."""

import ast
import re
from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import perspective
from ncdc_model.calibration.files.lens import file_lens, matrix_of, numbers, whole
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_mrcal", "mrcal_lens"]

_COEFFICIENTS = {"LENSMODEL_PINHOLE": 0, "LENSMODEL_OPENCV4": 4, "LENSMODEL_OPENCV5": 5,
                 "LENSMODEL_OPENCV8": 8, "LENSMODEL_OPENCV12": 12}
_NAMES = "lensmodel", "lens_model", "distortion_model"


def is_mrcal(text):
    """Whether ``text`` is a .cameramodel."""
    return re.search(r"['\"](lens_?model|distortion_model)['\"]\s*:\s*['\"](LENSMODEL|DISTORTION)_",
                     text) is not None


def mrcal_lens(text):
    """:class:`FileLens` of a .cameramodel, a dictionary in Python's notation.

    Raises
    ------
    InputError
        If the notation is wrong or the lens model is none of OpenCV's.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    try:
        table = ast.literal_eval(text.strip())
    except SyntaxError as error:
        raise InputError(f"it is no .cameramodel of mrcal: line {error.lineno}, column "
                         f"{error.offset}: {error.msg}") from error
    except (MemoryError, RecursionError) as error:
        raise InputError("it is no .cameramodel of mrcal: it is nested too deep") from error
    if not isinstance(table, dict):
        raise InputError("it is no .cameramodel of mrcal: it holds no names and values")
    model = next((table[name] for name in _NAMES if name in table), None)
    model = str(model).replace("DISTORTION_", "LENSMODEL_").replace("_NONE", "_PINHOLE")
    if model not in _COEFFICIENTS:
        raise InputError(f"the lens model is {model} of mrcal, one of {', '.join(_COEFFICIENTS)} "
                         f"is needed")
    check_read(table, (*_NAMES, "intrinsics"))
    width, height = table["imagersize"]
    count = _COEFFICIENTS[model]
    values = numbers(table["intrinsics"], f"list of intrinsics of {model}", (4 + count,))
    k = values[4:] if count else np.zeros(4)
    return file_lens((whole(width, "width"), whole(height, "height")), matrix_of(*values[:4]),
                     partial(perspective, coefficients=k), f"mrcal {model}")
