"""The network's integers compared with exact fractions, rounded once."""

from dataclasses import replace
from fractions import Fraction
from math import floor

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.golden.network import (
    coordinates,
    frame_coordinates,
    hidden_neuron,
    network,
    normalised_scan,
    output_neuron,
    round_between,
)
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.fixed import Q
from ncdc_spec.formats import Formats
from ncdc_spec.geometry import Geometry
from ncdc_spec.tansig import design_for, tansig

FORMATS = Formats()
SKIPS = {"coarser": Q(12, 9), "as fine": Q(12, 10), "finer": Q(12, 12)}    # than 21 + 12 bits
# Sums whose shifts are longer than what they shift to.
SHORT = Formats(input=Q(1, 12), hidden_weight=Q(4, 14), hidden_bias=Q(5, 9), net=Q(5, 19),
                output_bias=Q(14, 10), coordinate=Q(14, 6), skip_weight=Q(12, 3))


def value(raw, q):
    return Fraction(int(raw), 1 << q.f_bits)


def rounded(exact, q):
    """The nearest raw value of ``q``, half up, limited to its range."""
    raw = floor(exact * (1 << q.f_bits) + Fraction(1, 2))
    return min(max(raw, -(1 << q.i_bits + q.f_bits - 1)), (1 << q.i_bits + q.f_bits - 1) - 1)


def random_raw(rng, q, shape):
    return rng.integers(-(1 << q.i_bits + q.f_bits - 1), 1 << q.i_bits + q.f_bits - 1, shape)


def ends_and_more(rng, q, count):
    """Both ends of ``q``, with which sums saturate, and random values between."""
    return [q.lo, q.hi, *random_raw(rng, q, count - 2)]


def lens(skip=None, nodes=1):
    """Three neurons on 40 x 24 pixels; ``skip``: format of the weights of a skip path."""
    d = barrel_descriptor((40, 24), (64, 48))
    if skip:
        weights = np.array([[7.3, -4.4], [8.123, 5.5]])
        d = Descriptor.quantise(replace(d.network, skip_weights=weights), d.geometry, d.valid,
                                replace(d.formats, skip_weight=skip))
    return replace(d, nodes=nodes)


def exact_network(d, x, y, formats):
    """(x', y') of one input by equations (15)-(17), the tan-sigmoid's integers given."""
    x, y = value(x, formats.input), value(y, formats.input)
    outputs = []
    activations = []
    for weights, bias in zip(d.hidden_weights, d.hidden_biases):
        net = sum(value(w, formats.hidden_weight) * p for w, p in zip(weights, (x, y)))
        net = rounded(net + value(bias, formats.hidden_bias), formats.net)
        activations.append(value(tansig(net, design_for()), formats.tansig))
    for k in range(2):
        total = value(d.output_biases[k], formats.output_bias) + sum(
            value(w, formats.output_weight) * a for w, a in zip(d.output_weights[k], activations))
        if d.skip_weights is not None:
            total += sum(value(w, formats.skip_weight) * p
                         for w, p in zip(d.skip_weights[k], (x, y)))
        outputs.append(rounded(total, formats.coordinate))
    return outputs


@pytest.mark.parametrize("formats", [FORMATS, SHORT])
def test_the_scan_is_rounded_once(formats):
    geometry, q = Geometry(24, 9, 24, 9), formats.input
    u, v = np.arange(-30, 60), np.arange(60, -30, -1)
    got = normalised_scan(u, v, geometry, formats)
    origin_x, step_x, origin_y, step_y = geometry.scan()
    for values, pixels, origin, step in zip(got, (u, v), (origin_x, origin_y), (step_x, step_y)):
        assert values.tolist() == [rounded(Fraction(origin + int(pixel) * step, 1 << 31), q)
                                   for pixel in pixels]
        assert {q.lo, q.hi} < set(values.tolist())
    assert normalised_scan(3, 4, geometry, formats)[0] == got[0][33]


@pytest.mark.parametrize("formats", [FORMATS, SHORT])
def test_a_hidden_neuron_is_exact_and_rounded_once(formats):
    rng = np.random.default_rng(5)
    x, y = random_raw(rng, formats.input, (2, 80))
    seen = set()
    for weights, bias in zip(random_raw(rng, formats.hidden_weight, (6, 2)),
                             ends_and_more(rng, formats.hidden_bias, 6)):
        got = hidden_neuron(x, y, weights, bias, formats)
        assert got.tolist() == [
            rounded(value(a, formats.input) * value(weights[0], formats.hidden_weight)
                    + value(b, formats.input) * value(weights[1], formats.hidden_weight)
                    + value(bias, formats.hidden_bias), formats.net) for a, b in zip(x, y)]
        seen |= set(got.tolist())
    assert {formats.net.lo, formats.net.hi} < seen
    assert hidden_neuron(x.tolist(), y.tolist(), weights, bias, formats).tolist() == got.tolist()


@pytest.mark.parametrize("skip", [None, *SKIPS])
@pytest.mark.parametrize("formats", [FORMATS, replace(FORMATS, input=Q(1, 21)), SHORT])
def test_an_output_neuron_is_exact_and_rounded_once(skip, formats):
    rng, input = np.random.default_rng(6), formats.input
    formats = formats if formats == SHORT else replace(formats, skip_weight=SKIPS.get(skip))
    activations = list(random_raw(rng, formats.tansig, (3, 40)))
    inputs = tuple(random_raw(rng, input, (2, 40)))
    seen = set()
    for weights, bias in zip(random_raw(rng, formats.output_weight, (8, 3)),
                             ends_and_more(rng, formats.output_bias, 8)):
        skips = None if skip is None else random_raw(rng, formats.skip_weight, 2)
        got = output_neuron(activations, weights, bias, formats, inputs, skips)
        for n, raw in enumerate(got.tolist()):
            exact = value(bias, formats.output_bias) + sum(
                value(w, formats.output_weight) * value(a[n], formats.tansig)
                for w, a in zip(weights, activations))
            if skip is not None:
                exact += sum(value(w, formats.skip_weight) * value(p[n], input)
                             for w, p in zip(skips, inputs))
            assert raw == rounded(exact, formats.coordinate)
        seen |= set(got.tolist())
    assert {formats.coordinate.lo, formats.coordinate.hi} < seen


@pytest.mark.parametrize("skip", [None, *SKIPS])
def test_the_network_is_its_neurons(skip):
    d = lens(SKIPS.get(skip))
    x, y = random_raw(np.random.default_rng(7), d.formats.input, (2, 12))
    got = network(d, x, y)
    for n in range(len(x)):
        assert [part[n] for part in got] == exact_network(d, x[n], y[n], d.formats)
    # Formats of another input and coordinate, as views have them.
    other = replace(d.formats, input=Q(2, 22), coordinate=Q(14, 12))
    got = network(d, x // 2, y // 2, other)
    for n in range(len(x)):
        assert [part[n] for part in got] == exact_network(d, x[n] // 2, y[n] // 2, other)


@pytest.mark.parametrize("nodes", [1, 8])
def test_coordinates_of_pixels(nodes):
    d = lens(nodes=nodes)
    formats, out = d.network_formats, d.formats.coordinate
    # Neither sorted nor all different; one row for all columns.
    u, v = np.array([39, 0, 17, 17, 8, 23]), np.array([[5], [23], [0]])
    got = coordinates(d, u, v)

    def at(column, row):
        raw = [rounded(Fraction(origin + int(pixel) * step, 1 << 31), formats.input)
               for pixel, (origin, step) in zip((column, row), np.reshape(d.geometry.scan(),
                                                                          (2, 2)).tolist())]
        return [value(each, formats.coordinate) for each in exact_network(d, *raw, formats)]
    for n, row in enumerate(v[:, 0]):
        for m, column in enumerate(u):
            k, j = divmod(int(column), nodes)
            p0, p1, p2, p3 = (np.array(at((k + step) * nodes, row)) for step in (-1, 0, 1, 2))
            exact = p1 + j * (p2 - p1) / nodes - Fraction(j * (nodes - j), 4 * nodes**2) * (
                (p3 - p2) - (p1 - p0))
            assert [part[n, m] for part in got] == [rounded(each, out) for each in exact]
    empty = coordinates(d, np.empty((0, 4), int), 3)
    assert np.shape(empty) == (2, 0, 4)
    whole = frame_coordinates(d)
    assert whole[0].shape == whole[1].shape == (24, 40)
    for part, some in zip(whole, got):
        np.testing.assert_array_equal(part[v, u], some)


def test_sums_between_nodes_are_rounded_once():
    d = lens(nodes=8)
    sums = np.random.default_rng(8).integers(-1 << 40, 1 << 40, 50)
    fine = d.network_formats.coordinate
    assert round_between(sums, d).tolist() == [
        rounded(Fraction(int(each), 4 * 8**2 << fine.f_bits), d.formats.coordinate)
        for each in sums]
