"""Eight simulated wide-angle lenses with flaws for comparing accuracy, and their dots.

PC105 and PC120 are about as difficult as the lenses of the paper's Table III. The others view
105 or 120 degrees, across the width or (d) across the diagonal; kb and br name the radial model,
Kannala-Brandt or rational. ``lenses.json`` holds the parameters of :meth:`Camera.from_dict`, and as
``check`` exact values (u, v, x, y) of the back-map.
"""

import json
from functools import cache
from importlib.resources import files

import numpy as np

from ncdc_model.lens import Camera
from ncdc_model.training.problem import Problem
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import Geometry

__all__ = ["COLUMNS", "MARGIN", "NOISE", "REFERENCE_LENSES", "ROWS", "ReferenceLens",
           "reference_table"]

REFERENCE_LENSES = ("PC105", "PC120", "105kb", "105br", "105dbr", "120kb", "120br", "120dbr")

COLUMNS, ROWS = 31, 21      # dots over the corrected frame
INSET = 8                   # pixels from the frame's border to the outermost dots
MARGIN = 6                  # smallest distance of a dot's centre from the photo's border in pixels
NOISE = 0.05                # standard deviation per axis, distorted pixels
SEED = 1000                 # of the noise for which the accuracy goals were set
DIGITS = 6                  # of the dots, as in a points file


@cache
def _tables():
    return json.loads(files(__package__).joinpath("lenses.json").read_text())


def reference_table(name):
    """The parameters of the lens ``name``; raises InputError if there is none."""
    if name not in REFERENCE_LENSES:
        raise InputError(f"lens is {name!r}, one of {', '.join(REFERENCE_LENSES)} is needed")
    return _tables()[name]


class ReferenceLens:
    """One of the lenses: its exact map and the noisy dots of its calibration.

    Parameters
    ----------
    name : str
        One of :data:`REFERENCE_LENSES`.
    residual : float
        Factor 0 to 1 of the lens's own residual. At 0 it has radial distortion, decentring, thin
        prism and tilted sensor, as in OpenCV's models.

    Raises
    ------
    InputError
        If there is no such lens, or ``residual`` is beyond the limits.
    """

    def __init__(self, name, residual=1.0):
        if not 0 <= residual <= 1:
            raise InputError(f"the residual is {residual:g} times the lens's own, the limits are 0 "
                             f"and 1")
        self.name = name
        table = reference_table(name)
        table = {**table, "residual": {**table["residual"],
                                       "scale": residual * table["residual"]["scale"]}}
        self.camera = Camera.from_dict(table)
        self.geometry = Geometry(*self.camera.frame.size, *self.camera.size)

    def dots(self, noise=NOISE, seed=SEED):
        """The visible dots of a page, with Gaussian noise, as a :class:`Problem`.

        The page fills the corrected frame; ``noise`` is in pixels per axis.
        """
        width, height = self.geometry.corrected
        u, v = np.meshgrid(np.linspace(INSET, width - 1 - INSET, COLUMNS),
                           np.linspace(INSET, height - 1 - INSET, ROWS))
        x, y = self.camera.back_map(u, v)
        seen = _inside(x, y, self.geometry, MARGIN)
        # Noise of all dots, visible or not, so that all lenses of one seed have the same noise.
        dx, dy = noise * np.random.default_rng(seed).standard_normal((2, ROWS, COLUMNS))
        values = (np.round(value[seen], DIGITS) for value in (u, v, x + dx, y + dy))
        return Problem(*values, self.geometry)

    def truth(self, step=1):
        """All corrected pixels (u, v) with sources (x, y), as a :class:`Problem`.

        ``step``: distance of columns and rows.
        """
        width, height = self.geometry.corrected
        u, v = np.meshgrid(np.arange(0.0, width, step), np.arange(0.0, height, step))
        x, y = self.camera.back_map(u, v)
        seen = _inside(x, y, self.geometry, 0)
        return Problem(u[seen], v[seen], x[seen], y[seen], self.geometry)


def _inside(x, y, geometry, margin):
    width, height = geometry.distorted
    return ((x >= margin) & (x <= width - 1 - margin)
            & (y >= margin) & (y <= height - 1 - margin))
