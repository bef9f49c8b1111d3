"""Cameras of camodocal, as VINS-Mono and VINS-Fusion use them."""

from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import fisheye, perspective, unified_sphere
from ncdc_model.calibration.files.lens import file_lens, matrix_of, numbers
from ncdc_model.calibration.files.opencv import size_of
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["camodocal_lens", "is_camodocal"]

_FOCAL = {"PINHOLE": ("fx", "fy", "cx", "cy"), "PINHOLE_FULL": ("fx", "fy", "cx", "cy"),
          "KANNALA_BRANDT": ("mu", "mv", "u0", "v0"), "MEI": ("gamma1", "gamma2", "u0", "v0")}
_COEFFICIENTS = {"PINHOLE": ("k1", "k2", "p1", "p2"),
                 "PINHOLE_FULL": ("k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"),
                 "KANNALA_BRANDT": ("k2", "k3", "k4", "k5"), "MEI": ("k1", "k2", "p1", "p2")}


def is_camodocal(table):
    """Whether the names and values are those of a camera of camodocal."""
    return "model_type" in table


def camodocal_lens(table):
    """:class:`FileLens` of PINHOLE, PINHOLE_FULL, KANNALA_BRANDT or MEI.

    KANNALA_BRANDT's k2 ... k5 may be among the projection parameters, as
    camodocal writes them, or among the distortion parameters.

    Raises
    ------
    InputError
        If the model is another.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    model = str(table["model_type"]).upper()
    if model not in _FOCAL:
        raise InputError(f"the model is {model} of camodocal, one of {', '.join(_FOCAL)} is needed")
    projection = table["projection_parameters"]
    values = {**(table.get("distortion_parameters") or {}), **projection}
    check_read(table, ("model_type", "distortion_parameters", "projection_parameters",
                       "mirror_parameters"))
    check_read(values, _COEFFICIENTS[model] + _FOCAL[model])
    k = numbers([values[name] for name in _COEFFICIENTS[model]], "list of distortion coefficients")
    matrix = matrix_of(*(projection[name] for name in _FOCAL[model]))
    if model == "MEI":
        xi, = numbers(table["mirror_parameters"]["xi"], "value xi", (1,))
        distortion = partial(unified_sphere, offset=xi, radial=k[:2], tangential=k[2:])
    else:
        distortion = partial(fisheye if model == "KANNALA_BRANDT" else perspective, coefficients=k)
    return file_lens(size_of(table), np.asarray(matrix), distortion, f"camodocal {model}")
