"""MATLAB cameras: Bouguet's Calib_Results.m and .mat, and structs of cameraParameters."""

import pickle
import re
import subprocess
import sys
from functools import partial

import numpy as np

from ncdc_model.calibration.files.distortion import perspective
from ncdc_model.calibration.files.lens import choose, file_lens, matrix_of, numbers, whole
from ncdc_model.calibration.files.ocam import ocam_struct_lens
from ncdc_model.calibration.files.unread import check_read
from ncdc_spec.errors import InputError

__all__ = ["is_script", "mat_lens", "script_lens"]

_NAME = re.compile(r"(fc|cc|kc|alpha_c|nx|ny)(?:_(left|right))?")
# Reads a .mat in a process of its own, as damaged ones end SciPy by a segmentation fault. Photos,
# which may be among the variables, are left out.
_LOAD = """
import pickle, re, sys
from io import BytesIO
import scipy.io
content = BytesIO(sys.stdin.buffer.read())
kinds = {name: kind for name, _, kind in scipy.io.whosmat(content)}
wanted = [name for name, kind in kinds.items()
          if re.fullmatch(sys.argv[1], name) or kind in ("struct", "object")]
content.seek(0)
table = scipy.io.loadmat(content, simplify_cells=True, variable_names=wanted)
pickle.dump((kinds, table), sys.stdout.buffer)
"""
_SECONDS = 60          # of a .mat of the largest size
_VALUE = re.compile(r"(?m)^[ \t]*(\w+)[ \t]*=[ \t]*(\[[^\]]*\]|[^;%\n]*)")


def is_script(text):
    """Whether ``text`` is a Calib_Results.m."""
    return re.search(r"(?m)^[ \t]*fc(_left|_right)?[ \t]*=[ \t]*\[", text) is not None


def script_lens(text, camera=None):
    """:class:`FileLens` of a Calib_Results.m; ``camera`` of a stereo file is left or right.

    Raises
    ------
    InputError
        If the camera is not chosen or absent, or a value is no number.
    KeyError
        If a value is missing.
    """
    table = {}
    for name, value in _VALUE.findall(text):
        if _NAME.fullmatch(name):
            plain = re.sub(r"\.\.\.[^\n]*\n|[\[\];,]", " ", value)
            try:
                table[name] = [float(part) for part in plain.split()]
            except ValueError as error:
                raise InputError(f"{name} is {' '.join(value.split())}, numbers are "
                                 f"needed") from error
    return _bouguet(table, camera)


def mat_lens(content, camera=None):
    """:class:`FileLens` of a .mat: Bouguet's variables, or a struct of ``toStruct(cameraParams)``.

    Raises
    ------
    InputError
        If the file is no .mat before 7.3, holds neither, or the camera is not chosen or absent.
    KeyError, TypeError, ValueError
        If a value is missing or of the wrong kind.
    """
    if content.startswith(b"\x89HDF") or b"MATLAB 7.3" in content[:128]:
        raise InputError("it is a .mat of version 7.3, which is not supported; save it with "
                         "-v7")
    kinds, table = _loaded(content)
    if any(_NAME.fullmatch(name) and name.startswith("fc") for name in table):
        return _bouguet(table, camera)
    if isinstance(model := table.get("ocam_model"), dict):
        if camera is not None:
            raise InputError(f"camera {camera} is asked for, the file holds one camera without a "
                             f"name")
        return ocam_struct_lens(model)
    if {"ocam_model", "calib_data"} & kinds.keys():
        raise InputError("it is a file of OCamCalib whose model is an object; export it with the "
                         "toolbox's button Export Data, as calib_results.txt")
    structs = _structs(table)
    if not structs:
        raise InputError("it holds no camera: fc, cc and kc of Bouguet's toolbox or a struct is "
                         "needed; an object is saved as one by toStruct(cameraParams)")
    return _parameters(structs[choose(structs, camera)])


def _loaded(content):
    """Class of each variable of a .mat, and the values of those that may be a camera."""
    try:
        done = subprocess.run([sys.executable, "-c", _LOAD, _NAME.pattern], input=content,
                              capture_output=True, timeout=_SECONDS)
    except subprocess.TimeoutExpired as error:
        raise InputError(f"it is no .mat that can be read: SciPy takes more than {_SECONDS} s"
                         ) from error
    if done.returncode:
        reason = done.stderr.decode(errors="replace").strip().splitlines()[-1:]
        raise InputError(f"it is no .mat that can be read: "
                         f"{reason[0] if reason else 'SciPy ended while it read it'}")
    return pickle.loads(done.stdout)


def _bouguet(table, camera):
    sides = {found[2] for name in table if (found := _NAME.fullmatch(str(name))) and found[2]}
    if "fc" in table:
        if camera is not None:
            raise InputError(f"camera {camera} is asked for, the file holds one camera without a "
                             f"name")
        end = ""
    else:
        end = "_" + choose(sorted(sides), camera)
    fx, fy = numbers(table["fc" + end], "focal length fc", (2,))
    # The toolbox counts pixels from 0, unlike MATLAB.
    cx, cy = numbers(table["cc" + end], "principal point cc", (2,))
    alpha, = numbers(table.get("alpha_c" + end, 0.0), "skew alpha_c", (1,))
    k = numbers(table["kc" + end], "list of coefficients kc")
    if len(k) == 4 and k.any():
        raise InputError("kc has 4 coefficients, which may be those of the toolbox's fisheye; with "
                         "a fifth one, 0, they are perspective")
    if len(k) not in (4, 5):
        raise InputError(f"kc has {len(k)} coefficients, 5 are needed")
    sides = [table.get(name + end, table.get(name)) for name in ("nx", "ny")]
    size = None
    if None not in sides:
        (width,), (height,) = (numbers(side, "image size", (1,)) for side in sides)
        size = whole(width, "width"), whole(height, "height")
    return file_lens(size, matrix_of(fx, fy, cx, cy, alpha * fx), partial(perspective,
                     coefficients=k), "Bouguet" + end.replace("_", " "))


def _structs(table, name=""):
    if "RadialDistortion" in table or "MappingCoefficients" in table:
        return {name: table}
    found = {}
    for key, value in table.items():
        if isinstance(value, dict):
            found |= _structs(value, f"{name}.{key}" if name else str(key))
    return found


def _parameters(table):
    if "MappingCoefficients" in table:
        raise InputError("it is a fisheyeParameters of MATLAB, whose model of Scaramuzza is not "
                         "supported")
    if np.size(table.get("K", ())) == 9:
        matrix = np.array(table["K"], np.float64)
    else:
        matrix = np.array(table["IntrinsicMatrix"], np.float64).T
    if matrix.shape != (3, 3) or (matrix[2] != (0, 0, 1)).any() or matrix[1, 0]:
        raise InputError(f"the intrinsic matrix is {matrix.tolist()}, [[fx, s, cx], [0, fy, cy], "
                         f"[0, 0, 1]] is needed")
    radial = numbers(table["RadialDistortion"], "list RadialDistortion")
    if len(radial) not in (2, 3):
        raise InputError(f"RadialDistortion has {len(radial)} numbers, 2 or 3 are needed")
    tangential = numbers(table.get("TangentialDistortion", [0, 0]), "list TangentialDistortion",
                         (2,))
    check_read(table, ("RadialDistortion", "TangentialDistortion", "Intrinsics",
                       "NumRadialDistortionCoefficients", "EstimateTangentialDistortion"))
    k = np.array([*radial[:2], *tangential, *radial[2:], *[0.0] * (3 - len(radial))])
    rows_columns = np.ravel(table.get("ImageSize", ()))
    size = None
    if rows_columns.size:
        height, width = numbers(rows_columns, "ImageSize", (2,))
        size = whole(width, "width"), whole(height, "height")
    # MATLAB counts pixels from 1.
    return file_lens(size, matrix_of(matrix[0, 0], matrix[1, 1], matrix[0, 2] - 1,
                                     matrix[1, 2] - 1, matrix[0, 1]),
                     partial(perspective, coefficients=k), "MATLAB cameraParameters")
