"""Small descriptors for tests: real barrel maps, without training."""

import numpy as np

from ncdc_spec.descriptor import Descriptor, FloatNetwork
from ncdc_spec.geometry import Geometry, ValidRows

__all__ = ["barrel_descriptor", "barrel_map"]


def barrel_map(geometry, strength=0.25):
    """Back-map of a plain barrel: (u, v) -> (x, y), the full width in view."""
    wc, hc = geometry.corrected
    wd, hd = geometry.distorted

    def back_map(u, v):
        a = (np.asarray(u) - (wc - 1) / 2) * 2 / wc
        b = (np.asarray(v) - (hc - 1) / 2) * 2 / wc
        scale = (1 + strength) / (1 + strength * (a * a + b * b)) * wd / 2
        return a * scale + (wd - 1) / 2, b * scale + (hd - 1) / 2

    return back_map


def barrel_descriptor(corrected=(48, 40), distorted=(48, 40), hidden_neurons=3, seed=1,
                      strength=0.25, **geometry):
    """Descriptor of :func:`barrel_map`: random hidden layer, output layer by least squares.

    Rough (some pixels of error), but a map of the right kind with every weight in use.
    """
    g = Geometry(*corrected, *distorted, **geometry)
    rng = np.random.default_rng(seed)
    hidden, biases = rng.uniform(-2, 2, (hidden_neurons, 2)), rng.uniform(-1, 1, hidden_neurons)
    v, u = (a.ravel() for a in np.mgrid[0:g.corrected_height:3, 0:g.corrected_width:3])
    x, y = g.normalise(u, v)
    columns = np.column_stack([np.tanh((np.column_stack([x, y]) @ hidden.T + biases) / 2),
                               np.ones_like(x)])
    target = np.column_stack(barrel_map(g, strength)(u, v))
    ridge = 1e-4 * len(x) * np.eye(hidden_neurons + 1)
    solution = np.linalg.solve(columns.T @ columns + ridge, columns.T @ target)
    network = FloatNetwork(hidden, biases, solution[:-1].T, solution[-1])
    vv, uu = np.indices(g.corrected[::-1])
    valid = ValidRows.of_mask(g.window_inside(*barrel_map(g, strength)(uu, vv)))
    return Descriptor.quantise(network, g, valid)
