"""The front end in integers: scan, hidden neurons, tan-sigmoid, output neurons."""

import numpy as np

from ncdc_model.fixed import requantise
from ncdc_model.geometry import SCAN
from ncdc_model.tansig import tansig

__all__ = ["coordinates", "frame_coordinates", "hidden_neuron", "network", "normalised_scan",
           "output_neuron"]


def normalised_scan(u, v, geometry, formats):
    """Raw ``formats.input`` coordinates (x, y) of corrected pixels ``u``, ``v`` (integers).

    origin + u * step, exact in :data:`SCAN`, rounded once.
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

    Denormalisation is part of it: the weights are in pixels. ``activations``: the raw
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


def network(descriptor, x, y):
    """Raw coordinates (x', y') of raw normalised (x, y): all neurons."""
    d, formats = descriptor, descriptor.formats
    activations = [tansig(hidden_neuron(x, y, weights, bias, formats), d.tansig)
                   for weights, bias in zip(d.hidden_weights, d.hidden_biases)]
    skips = (None, None) if d.skip_weights is None else d.skip_weights
    return tuple(output_neuron(activations, weights, bias, formats, (x, y), skip)
                 for weights, bias, skip in zip(d.output_weights, d.output_biases, skips))


def coordinates(descriptor, u, v):
    """Raw back-map coordinates (x', y') in ``formats.coordinate`` of corrected pixels (u, v)."""
    return network(descriptor, *normalised_scan(u, v, descriptor.geometry, descriptor.formats))


def frame_coordinates(descriptor):
    """Raw (x', y') of the whole corrected frame, each of shape (height, width)."""
    v, u = np.indices(descriptor.geometry.corrected[::-1])
    return coordinates(descriptor, u, v)
