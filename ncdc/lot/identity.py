"""What judges a unit: versions of the software of a worker, and a digest of its code."""

import hashlib
import platform
from functools import cache
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

import cv2
import numpy as np

__all__ = ["IDENTITY", "differences", "identity"]

# Columns of the database, and their names in words.
IDENTITY = {"software": "NCDC", "code": "code of NCDC", "numpy": "NumPy", "opencv": "OpenCV",
            "python": "Python"}
_PACKAGES = "ncdc.lot", "ncdc_model", "ncdc_spec"       # what decides on figures and verdicts
_DIGITS = 16


@cache
def identity():
    """Texts by name of :data:`IDENTITY` of the process that calls it.

    ``code`` is the start of the SHA-256 of all modules of the packages that judge, with their
    names. It is read once: a process goes on with the code with which it began.
    """
    return {"software": version("ncdc"), "code": _digest(), "numpy": np.__version__,
            "opencv": cv2.__version__, "python": platform.python_version()}


def _digest():
    found = hashlib.sha256()
    for package in _PACKAGES:
        for folder in import_module(package).__path__:
            for path in sorted(Path(folder).rglob("*.py")):
                # A checkout may end lines in its own way.
                content = path.read_bytes().replace(b"\r\n", b"\n")
                found.update(f"{package}/{path.relative_to(folder).as_posix()} {len(content)}\n"
                             .encode() + content)
    return found.hexdigest()[:_DIGITS]


def differences(worker, driver):
    """Text on what differs between two results of :func:`identity`; empty if nothing does."""
    return ", ".join(f"{title} {worker.get(name)}, here {driver[name]}"
                     for name, title in IDENTITY.items() if worker.get(name) != driver[name])
