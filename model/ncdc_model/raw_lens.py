"""A lens without correction: the raw picture, scaled to the corrected picture's size."""

import numpy as np

from ncdc_spec.descriptor import Descriptor
from ncdc_spec.float_network import FloatNetwork
from ncdc_spec.geometry import ValidRows

__all__ = ["raw_lens", "raw_map"]

_SHARE = .9             # of the output weights' range that is used
_STEEPER = 1.1
_POINTS = 33            # along each side, to which the output layer is fitted


def raw_map(geometry):
    """Back-map (u, v) -> (x, y) that takes the whole raw frame to the whole corrected one."""
    (wc, hc), (wd, hd) = geometry.corrected, geometry.distorted

    def back_map(u, v):
        return ((np.asarray(u) + .5) * (wd / wc) - .5, (np.asarray(v) + .5) * (hd / hc) - .5)

    return back_map


def raw_lens(descriptor):
    """A :class:`Descriptor` of :func:`raw_map` that fits the hardware of ``descriptor``.

    Half of the hidden neurons compute x, the others y. They use the middle of the tan-sigmoid, as
    nearly linear as the output weights' range allows. A single neuron computes x; y is constant.
    """
    g, neurons = descriptor.geometry, descriptor.hidden_neurons
    follows_y = np.arange(neurons) % 2
    counts = np.maximum(1, [neurons - follows_y.sum(), follows_y.sum()])
    q = descriptor.formats.output_weight
    # tanh(s x / 2) is about s x / 2: a single neuron needs a weight of size / s.
    slope = max(g.distorted / counts) / (_SHARE * q.real(q.hi))
    v, u = (a.ravel() for a in np.meshgrid(np.linspace(0, g.corrected_height - 1, _POINTS),
                                           np.linspace(0, g.corrected_width - 1, _POINTS),
                                           indexing="ij"))
    x, y = g.normalise(u, v)
    target = np.column_stack(raw_map(g)(u, v))
    while True:
        columns = np.column_stack([np.tanh(slope * x / 2), np.tanh(slope * y / 2),
                                   np.ones_like(x)])
        weights = np.linalg.lstsq(columns, target, rcond=None)[0]
        output = (weights[:2] / counts[:, None])[follows_y].T
        if abs(output).max() < q.real(q.hi):
            break
        slope *= _STEEPER       # the curve of the tan-sigmoid needed larger weights
    hidden = slope * np.column_stack([1 - follows_y, follows_y])
    skip = None if descriptor.skip_weights is None else np.zeros((2, 2))
    network = FloatNetwork(hidden, np.zeros(neurons), output, weights[2], skip_weights=skip)
    rows, cols = np.indices(g.corrected[::-1])
    valid = ValidRows.of_mask(g.window_inside(*raw_map(g)(cols, rows)))
    return Descriptor.quantise(network, g, valid, descriptor.formats, variant=descriptor.variant,
                               nodes=descriptor.nodes)
