"""The simulated lenses beside the repository on which the accuracy goals were set."""

import json
from pathlib import Path

import numpy as np
import pytest

from ncdc_model.geometry import Geometry
from ncdc_model.lens import Camera
from ncdc_model.training.problem import Problem

FOLDER = Path(__file__).resolve().parents[2] / "shared" / "lenses"


def reference_tables():
    """The parameters of all lenses by name; skips the test if they are not there."""
    if not FOLDER.is_dir():
        pytest.skip("the folder ../shared/lenses beside the repository is absent")
    return json.loads((FOLDER / "lenses.json").read_text())


def reference_lens(name):
    """The noisy calibration dots of the lens ``name``, and its exact map on a dense grid."""
    camera = Camera.from_dict(reference_tables()[name])
    width, height = camera.size
    geometry = Geometry(width, height, width, height)
    dots = np.loadtxt(FOLDER / f"{name}_dots.csv", delimiter=",", skiprows=1).T
    u, v = np.meshgrid(np.arange(0, width, 4.0), np.arange(0, height, 4.0))
    x, y = camera.back_map(u, v)
    inside = (x >= 0) & (x <= width - 1) & (y >= 0) & (y <= height - 1)
    dense = Problem(u[inside], v[inside], x[inside], y[inside], geometry)
    return Problem(*dots, geometry), dense
