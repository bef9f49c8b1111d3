"""Rounds a network to integers so that the rounding errors largely cancel."""

from dataclasses import replace

import numpy as np

from ncdc_model.exact import least_squares, triangular
from ncdc_model.golden.network import hidden_neuron, normalised_scan
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.tansig import tansig

__all__ = ["check_weight_bits", "fitted_formats", "round_network"]

SAMPLES = 48           # columns and rows of the grid of pixels on which errors are measured
WEIGHT_BITS = 18, 24   # limits


def check_weight_bits(bits):
    """Raise :class:`InputError` unless ``bits`` is 18 to 24."""
    low, high = WEIGHT_BITS
    if not low <= bits <= high:
        raise InputError(f"the weights shall have {bits} bits, the limits are {low} and {high}")


def fitted_formats(network, formats, bits):
    """``formats`` with weights and inputs of ``bits`` bits and the largest fraction that fits.

    The formats of the biases, which enter no product, do not change.
    """
    check_weight_bits(bits)

    def fitted(values):
        # A limit of one unit less allows rounding in either direction.
        limit = np.abs(values).max() * (1 + 2.0**(3 - bits))
        whole = 1 + max(0, int(np.floor(np.log2(limit))) + 1)
        return Q(whole, bits - whole)

    plain = network.with_gamma(1)
    skip = None if plain.skip_weights is None else fitted(plain.skip_weights)
    return replace(formats, input=Q(1, bits - 1), hidden_weight=fitted(plain.hidden_weights),
                   output_weight=fitted(plain.output_weights), skip_weight=skip)


def round_network(network, geometry, valid, formats, **about):
    """Descriptor of ``network`` whose integers together approximate it best.

    Rounding each number to nearest adds independent errors. Here the numbers are rounded one at a
    time, the coarsest first, and the free ones compensate for the fixed ones (the nearest-plane
    rule of integer least squares) on a grid of valid pixels. The first step rounds all numbers by
    the network's derivatives. The second rounds the output layer again, on the integer results of
    the hidden neurons.

    Parameters: as :meth:`Descriptor.quantise`.

    Raises
    ------
    InputError
        If a weight or bias leaves the range of its format.
    """
    draft = Descriptor.quantise(network, geometry, valid, formats, **about)
    u, v = _pixels(geometry, valid)
    if not len(u):
        return draft
    goal = np.stack(network(*geometry.normalise(u, v)))
    hidden = _round_all(draft, network.with_gamma(1), *geometry.normalise(u, v))
    return _round_output(hidden, u, v, goal)


def _pixels(geometry, valid):
    """Valid pixels (u, v) of a grid that includes the border of the frame."""
    width, height = geometry.corrected
    u, v = (axis.ravel() for axis in np.meshgrid(
        *(np.unique(np.linspace(0, size - 1, SAMPLES).astype(int)) for size in (width, height))))
    on = valid.mask(width)[v, u]
    return u[on], v[on]


def _round_all(draft, network, x, y):
    """``draft`` with the hidden layer from rounding all numbers together."""
    f = draft.formats
    ones = np.ones_like(x)
    wx, wy = network.hidden_weights.T[:, :, None]
    nets = wx * x + wy * y + network.hidden_biases[:, None]
    active = np.tanh(nets / 2)
    slope = .5 * (1 - active**2)
    hn = draft.hidden_neurons
    # Derivatives of both outputs by every number: (2, numbers, pixels).
    columns, reals, formats = [], [], []

    def add(by_output, values, q):
        columns.extend(by_output)
        reals.extend(np.ravel(values))
        formats.extend([q] * np.size(values))

    for fan, values, q in ((x, network.hidden_weights[:, 0], f.hidden_weight),
                           (y, network.hidden_weights[:, 1], f.hidden_weight),
                           (ones, network.hidden_biases, f.hidden_bias)):
        add([weights[:, None] * slope[j] * fan
             for j, weights in enumerate(network.output_weights.T)], values, q)
    both = np.eye(2)[:, :, None]
    for k in range(2):
        add([both[k] * a for a in active], network.output_weights[k], f.output_weight)
        add([both[k] * ones], network.output_biases[k], f.output_bias)
        if f.skip_weight is not None:
            add([both[k] * x, both[k] * y], network.skip_weights[k], f.skip_weight)
    matrix = np.array(columns).reshape(len(columns), -1)
    raw = _nearest_plane(matrix, np.array(reals), formats)
    return replace(draft, hidden_weights=raw[:2 * hn].reshape(2, hn).T.copy(),
                   hidden_biases=raw[2 * hn:3 * hn])


def _round_output(draft, u, v, goal):
    """``draft`` with the output layer that approximates ``goal``, (2, N) in pixels, best."""
    f = draft.formats
    x, y = normalised_scan(u, v, draft.geometry, f)
    columns = [f.tansig.real(tansig(hidden_neuron(x, y, weights, bias, f), draft.tansig))
               for weights, bias in zip(draft.hidden_weights, draft.hidden_biases)]
    formats = [f.output_weight] * len(columns) + [f.output_bias]
    columns.append(np.ones(len(u)))
    if f.skip_weight is not None:
        columns += [f.input.real(x), f.input.real(y)]
        formats += [f.skip_weight] * 2
    matrix, hn = np.array(columns), draft.hidden_neurons
    raw = np.array([_nearest_plane(matrix, least_squares(matrix, wanted), formats)
                    for wanted in goal])
    about = {} if f.skip_weight is None else {"skip_weights": raw[:, hn + 1:]}
    return replace(draft, output_weights=raw[:, :hn], output_biases=raw[:, hn], **about)


def _nearest_plane(matrix, reals, formats):
    """Integers z in ``formats`` with small |(z - reals) matrix|; shape (numbers,).

    ``matrix``, (numbers, outputs): effect of each number, in units of its value, on every output.
    """
    step = np.array([2.0**-q.f_bits for q in formats])
    effect = matrix * step[:, None]
    order = np.argsort((effect**2).sum(1), kind="stable")
    upper = triangular(effect[order])
    wanted = (reals / step)[order]
    error = np.zeros(len(order))
    for k in range(len(order) - 1, -1, -1):
        pull = (upper[k, k + 1:] * error[k + 1:]).sum() / upper[k, k] if upper[k, k] else 0.0
        q = formats[order[k]]
        error[k] = np.clip(np.floor(wanted[k] - pull + .5), q.lo, q.hi) - wanted[k]
    raw = np.empty(len(order), np.int64)
    raw[order] = np.rint(wanted + error)
    return raw
