"""Lenses and networks of known formulas, 320x240."""

import numpy as np

from ncdc_model.lens import Camera
from ncdc_model.training.problem import Problem
from ncdc_spec.descriptor import FloatNetwork
from ncdc_spec.geometry import Geometry

__all__ = ["GEOMETRY", "equidistant", "known_network", "lens", "lens_problem"]

GEOMETRY = Geometry(320, 240, 320, 240)


def equidistant(u, v):
    """Back-map of an equidistant lens with a decentred element, 320x240."""
    a, b = (u - 158.0) / 190, (v - 121.0) / 190
    r = np.maximum(np.hypot(a, b), 1e-9)
    x, y = a * np.arctan(r) / r, b * np.arctan(r) / r
    return (190 * (x + .004 * x * y + .002 * (3 * x * x + y * y)) + 160,
            190 * (y + .004 * x * y + .002 * (x * x + 3 * y * y)) + 118)


def lens_problem(columns=20, rows=15):
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(4, 315, columns),
                                                 np.linspace(4, 235, rows)))
    return Problem(u, v, *equidistant(u, v), GEOMETRY)


def known_network(scale=1.0):
    return FloatNetwork(scale * np.array([[1.5, .4], [-.3, 1.7], [.9, -.8]]),
                        np.array([.3, -.2, .7]),
                        np.array([[110., 30, 12], [-20, 90, 25]]), np.array([161., 119]))


def lens():
    """A wide lens with a little of every distortion."""
    return Camera.from_dict({"width": 320, "height": 240, "f_distorted": 165.0, "k": [.03, .01],
                             "centre": [161.5, 117.8], "p": [.001, -.0006]})
