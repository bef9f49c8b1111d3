"""Compiles the C functions for the processor at hand, once, and loads them."""

import ctypes
import os
import shutil
import subprocess
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np

from ncdc_spec.builds import built, key_of
from ncdc_spec.errors import InputError
from ncdc_spec.needs import apt_line

__all__ = ["library", "pointer", "structure"]

_SOURCES = ("coordinates.c", "pictures.c", "products.c", "search.c")
# Integer arithmetic wraps as NumPy's does, and a product is rounded before it is added.
_FLAGS = ("-std=gnu11", "-O3", "-march=native", "-fwrapv", "-ffp-contract=off", "-fPIC", "-shared")
_NAME, _DIGEST = "model.so", "model.sha256"
_COMPILERS = ("cc", "gcc", "clang")


def library():
    """The shared library of the C functions.

    It is compiled at its first use on a machine, which takes seconds, and stays in the folder of
    the builds; one whose bytes have changed is compiled again. Its key includes all macros of the
    compiler: its version, and the instructions that this processor has.

    Raises
    ------
    InputError
        If there is no C compiler, it fails, or the folder of the builds cannot be written.
    """
    found = _loaded()
    if isinstance(found, InputError):
        raise found
    return found


@cache
def _loaded():
    """The library, or the error that it cannot be had by: what fails once is not tried again."""
    try:
        return _load()
    except InputError as error:
        return error


def _load():
    compiler = _compiler()
    sources = [Path(__file__).with_name(name) for name in _SOURCES]
    macros = _output([compiler, "-march=native", "-dM", "-E", "-x", "c", os.devnull])
    key = key_of("model", macros, *_FLAGS, *(source.read_text() for source in sources))

    def build(folder):
        _output([compiler, *_FLAGS, "-o", str(folder / _NAME), *map(str, sources)])
        (folder / _DIGEST).write_text(_digest(folder))
    folder = built(key, build, _whole)
    try:
        return ctypes.CDLL(str(folder / _NAME))
    except OSError as error:
        raise InputError(f"cannot load the compiled model: {error}") from error


def _digest(folder):
    return sha256((folder / _NAME).read_bytes()).hexdigest()


def _whole(folder):
    """Whether a build holds the bytes that were compiled: to load others may end the process."""
    try:
        return (folder / _DIGEST).read_bytes() == _digest(folder).encode()
    except OSError:
        return False


def _compiler():
    """Path of the C compiler: ``CC``, or the first one of those known."""
    for name in filter(None, (os.environ.get("CC"), *_COMPILERS)):
        if path := shutil.which(name):
            return path
    raise InputError(f"no C compiler is installed: {apt_line(['gcc'])}")


def _output(command):
    """What a compiler prints."""
    try:
        done = subprocess.run(command, capture_output=True, text=True)
    except OSError as error:
        raise InputError(f"cannot run {command[0]}: {error.strerror}") from error
    if done.returncode:
        last = (done.stderr.strip().splitlines() or ["no message"])[-1]
        raise InputError(f"{command[0]} cannot compile the model: {last}")
    return done.stdout


def pointer(array):
    """Address of a C-contiguous ``array`` for a C function."""
    assert array.flags.c_contiguous
    return ctypes.c_void_p(array.ctypes.data)


def structure(kind, **values):
    """Address of a structure, which holds on to the arrays that it points to."""
    arrays = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
    structure = kind(**values | {name: pointer(array) for name, array in arrays.items()})
    structure.arrays = arrays
    return ctypes.pointer(structure)
