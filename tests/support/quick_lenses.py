"""Points and networks of the lens of :func:`lenses.lens`, without photos and without training."""

import numpy as np

from lenses import lens
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.golden.valid import connected
from ncdc_model.lens import rotation
from ncdc_model.training.source import load_source
from ncdc_spec.descriptor import Descriptor, FloatNetwork
from ncdc_spec.geometry import ValidRows

__all__ = ["SIZE", "quick_descriptor", "save_points"]

SIZE = 320, 240
_TILTS = {"page.png": (3, -2), "a.png": (20, 15), "b.png": (-25, 5)}


def _quick_network(pairs, geometry, hidden=24):
    """A random hidden layer, and the output layer by least squares: no training."""
    u, v, x, y = pairs
    rng = np.random.default_rng(1)
    weights, biases = rng.uniform(-2, 2, (hidden, 2)), rng.uniform(-1, 1, hidden)
    inputs = np.column_stack(geometry.normalise(u, v))
    columns = np.column_stack([np.tanh((inputs @ weights.T + biases) / 2), np.ones(len(u))])
    ridge = 1e-7 * len(u) * np.eye(hidden + 1)
    solution = np.linalg.solve(columns.T @ columns + ridge, columns.T @ np.column_stack([x, y]))
    return FloatNetwork(weights, biases, solution[:-1].T, solution[-1])


def _page_points(tilts, name):
    """Points, without noise, of a page of dots at ``tilts`` in degrees, turned by two degrees."""
    grid = np.stack(np.meshgrid(np.arange(-8, 9), np.arange(-6, 7)), axis=-1).reshape(-1, 2)
    turn = rotation(*np.radians([*tilts, 2.0]))
    rays = [0, 0, 1] + .16 * grid @ turn[:, :2].T
    x, y = lens().distort(*(rays[:, :2] / rays[:, 2:]).T)
    on = (x > 3) & (x < 316) & (y > 3) & (y < 236)
    return PhotoPoints(grid[on] + 20, np.stack([x, y], axis=1)[on], np.zeros(on.sum()), {}, name)


def save_points(path):
    """Write the points of three photos of a page of dots; the first is ``page.png``."""
    TargetPoints("dots", SIZE, tuple(_page_points(tilts, name)
                                     for name, tilts in _TILTS.items())).save(path)


def quick_descriptor(points, **about):
    """Descriptor of a points file."""
    source = load_source(points)
    return Descriptor.quantise(
        _quick_network(source.pairs, source.geometry), source.geometry,
        ValidRows.of_mask(connected(source.smooth.unfolded)), provenance=source.provenance, **about)
