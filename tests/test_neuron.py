"""Neurons: gateware against the golden model, over every rounding and saturation edge."""

import numpy as np
import pytest
from pipelines import run_pipeline

from ncdc_hdl.neural.neuron import HiddenNeuron, OutputNeuron
from ncdc_model.descriptor import Formats
from ncdc_model.fixed import Q
from ncdc_model.network import hidden_neuron, output_neuron

FORMATS = Formats()


def bias_edges(xq, wq, bq, yq):
    """Biases that put the sum, with inputs of zero, on and beside each rounding step's edge."""
    shift = bq.f_bits - yq.f_bits          # of the bias alone; the products' bits are zero
    edges = [(edge << shift) - (1 << (shift - 1)) + d
             for edge in (yq.lo, yq.hi + 1, 0, 1, -1) for d in (-1, 0, 1)]
    return [b for b in (*edges, bq.lo, bq.hi) if bq.holds(b)]


def check(dut, model, xq, wq, bq, yq, rng):
    n = dut.inputs
    items = [([0] * n, [0] * n, b) for b in bias_edges(xq, wq, bq, yq)]
    for x in (xq.lo, xq.hi):
        for w in (wq.lo, wq.hi):
            for b in (bq.lo, bq.hi):
                items.append(([x] * n, [w] * n, b))
    # Small weights keep the sum in range, so that rounding and not saturation is compared.
    for scale in (1, 4, 64, 1024):
        for _ in range(8):
            items.append((rng.integers(xq.lo, xq.hi, n, endpoint=True).tolist(),
                          (rng.integers(wq.lo, wq.hi, n, endpoint=True) // scale).tolist(),
                          int(rng.integers(bq.lo, bq.hi, endpoint=True)) // scale))

    # Weights are static in a frame: each item gets the whole pipeline for itself.
    spaced = [item for item in items for _ in range(dut.latency)]

    def drive(ctx, item):
        for k in range(n):
            ctx.set(dut.i[k], item[0][k])
            ctx.set(dut.weights[k], item[1][k])
        ctx.set(dut.bias, item[2])

    got = np.ravel(run_pipeline(dut, spaced, drive, lambda: [dut.o]))[::dut.latency]
    expected = [int(model(*item)) for item in items]
    np.testing.assert_array_equal(got, expected)
    assert {yq.lo, yq.hi} <= set(expected) and len(set(expected)) > 20


@pytest.mark.parametrize("seed", [1, 2])
def test_hidden_neuron(seed):
    f = FORMATS
    check(HiddenNeuron(f), lambda x, w, b: hidden_neuron(x[0], x[1], w, b, f),
          f.input, f.hidden_weight, f.hidden_bias, f.net, np.random.default_rng(seed))


@pytest.mark.parametrize("inputs", [1, 2, 3, 5, 8])
def test_output_neuron(inputs):
    f = FORMATS
    check(OutputNeuron(inputs, f),
          lambda a, w, b: output_neuron([np.int64(v) for v in a], w, b, f),
          f.tansig, f.output_weight, f.output_bias, f.coordinate, np.random.default_rng(inputs))


def test_one_result_per_clock():
    f, rng = FORMATS, np.random.default_rng(3)
    dut = OutputNeuron(4, f)
    weights, bias = rng.integers(-2**20, 2**20, 4), 12345
    inputs = rng.integers(f.tansig.lo, f.tansig.hi, (300, 4))

    def drive(ctx, item):
        ctx.set(dut.bias, bias)
        for k in range(4):
            ctx.set(dut.weights[k], int(weights[k]))
            ctx.set(dut.i[k], int(item[k]))

    got = np.ravel(run_pipeline(dut, list(inputs), drive, lambda: [dut.o]))
    np.testing.assert_array_equal(got, output_neuron(list(inputs.T), weights, bias, f))


def test_refuses_formats_without_rounding():
    with pytest.raises(ValueError, match="Q5.43 keeps every fraction bit of the products Q1.23 x Q4.20"):
        HiddenNeuron(Formats(net=Q(5, 43)))
