"""Reference model of the front end in integers: scan, neurons, tan-sigmoid."""

import numpy as np

from ncdc_model.golden.nodes import between, node_grid, round_sums
from ncdc_spec.fixed import requantise
from ncdc_spec.geometry import SCAN
from ncdc_spec.tansig import tansig

__all__ = ["coordinates", "frame_coordinates", "hidden_neuron", "network", "normalised_scan",
           "output_neuron", "round_between"]


def normalised_scan(u, v, geometry, formats):
    """Raw ``formats.input`` coordinates (x, y) of corrected pixels ``u``, ``v`` (integers).

    The result is origin + u * step, exact in :data:`SCAN`, rounded once.
    """
    origin_x, step_x, origin_y, step_y = geometry.scan()
    shift = SCAN.f_bits - formats.input.f_bits
    return (requantise(origin_x + np.asarray(u, np.int64) * step_x, shift, formats.input),
            requantise(origin_y + np.asarray(v, np.int64) * step_y, shift, formats.input))


def hidden_neuron(x, y, weights, bias, formats):
    """Raw net of a hidden neuron, equation (15): weights . (x, y) + bias, exact, rounded once."""
    products = formats.input.f_bits + formats.hidden_weight.f_bits
    total = (np.asarray(x, np.int64) * int(weights[0]) + np.asarray(y, np.int64) * int(weights[1])
             + (int(bias) << (products - formats.hidden_bias.f_bits)))
    return requantise(total, products - formats.net.f_bits, formats.net)


def output_neuron(activations, weights, bias, formats, inputs=None, skip=None):
    """Raw coordinate in pixels: weights . activations + bias, exact, rounded once, saturated.

    The weights are in pixels, so that denormalisation is included. ``activations``: the raw
    tan-sigmoid results, one array per hidden neuron. With a skip path also + skip . inputs:
    ``inputs`` are the raw (x, y) of the hidden neurons, ``skip`` the two weights. The sum has the
    fraction bits of the finer products.
    """
    products = formats.tansig.f_bits + formats.output_weight.f_bits
    finest = products
    if skip is not None:
        skipped = formats.input.f_bits + formats.skip_weight.f_bits
        finest = max(products, skipped)
    total = np.full(np.shape(activations[0]),
                    int(bias) << (finest - formats.output_bias.f_bits), np.int64)
    for a, weight in zip(activations, weights):
        total += a * (int(weight) << (finest - products))
    if skip is not None:
        for x, weight in zip(inputs, skip):
            total += np.asarray(x, np.int64) * (int(weight) << (finest - skipped))
    return requantise(total, finest - formats.coordinate.f_bits, formats.coordinate)


def network(descriptor, x, y, formats=None):
    """Raw coordinates (x', y') of raw normalised (x, y), of one shape: all neurons.

    ``formats``: by default the descriptor's :attr:`network_formats`; others may differ from them in
    input and coordinate only.
    """
    d, formats = descriptor, formats or descriptor.network_formats
    activations = [tansig(hidden_neuron(x, y, weights, bias, formats), d.tansig)
                   for weights, bias in zip(d.hidden_weights, d.hidden_biases)]
    skips = (None, None) if d.skip_weights is None else d.skip_weights
    return tuple(output_neuron(activations, weights, bias, formats, (x, y), skip)
                 for weights, bias, skip in zip(d.output_weights, d.output_biases, skips))


def coordinates(descriptor, u, v):
    """Raw back-map coordinates (x', y') in ``formats.coordinate`` of corrected pixels (u, v).

    If the network is evaluated at nodes (``descriptor.nodes`` above 1), the sum of
    :func:`ncdc_model.golden.nodes.sums_between` is exact and rounded once.
    """
    d, formats = descriptor, descriptor.network_formats
    if d.nodes == 1:
        return network(d, *normalised_scan(u, v, d.geometry, formats))
    u, v = np.broadcast_arrays(np.asarray(u, np.int64), np.asarray(v, np.int64))
    if not u.size:
        return np.zeros((2, *u.shape), np.int64)
    columns, lines, nodes_of = node_grid(u, v, d.nodes)
    return tuple(round_between(between(nodes_of(table), u, d.nodes), d)
                 for table in network(d, *normalised_scan(columns, lines, d.geometry, formats)))


def round_between(sums, descriptor):
    """Coordinates of 4 S^2 times their value between nodes: the only rounding after the nodes."""
    return round_sums(sums, descriptor.nodes, descriptor.network_formats.coordinate,
                      descriptor.formats.coordinate)


def frame_coordinates(descriptor):
    """Raw (x', y') of the whole corrected frame, each of shape (height, width)."""
    v, u = np.indices(descriptor.geometry.corrected[::-1])
    return coordinates(descriptor, u, v)
