"""Neurons: gateware compared with the golden model, over every rounding and saturation edge."""

import numpy as np
import pytest

from ncdc_hdl.neural.neuron import HiddenNeuron, OutputNeuron, WeightedSum, hidden_sum, output_sum
from ncdc_model.golden.network import hidden_neuron, output_neuron
from ncdc_spec.descriptor import Formats
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.hardware import MULTIPLIER_BITS
from pipelines import run_pipeline
from saturations import WRONG_SATURATIONS

FORMATS = Formats()


def bias_edges(xq, wq, bq, yq):
    """Biases that put the sum, with inputs of zero, on and next to each rounding step's edge."""
    shift = bq.f_bits - yq.f_bits          # of the bias alone; the products' bits are zero
    edges = [(edge << shift) - (1 << (shift - 1)) + d
             for edge in (yq.lo, yq.hi + 1, 0, 1, -1) for d in (-1, 0, 1)]
    return [b for b in (*edges, bq.lo, bq.hi) if bq.holds(b)]


def check(dut, model, xq, wq, bq, yq, rng):
    n = dut.terms
    # The bias is coarser than the sum: products of +-1 walk the steps between.
    items = [([1] * n, [w] + [0] * (n - 1), b) for b in bias_edges(xq, wq, bq, yq)
             for w in (0, -1, 1)]
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


def check_hidden(seed=1, bits=27):
    f = FORMATS
    check(HiddenNeuron(f, bits), lambda x, w, b: hidden_neuron(x[0], x[1], w, b, f),
          f.input, f.hidden_weight, f.hidden_bias, f.net, np.random.default_rng(seed))


def check_output(inputs, bits=27):
    f = FORMATS
    check(OutputNeuron(inputs, f, multiplier_bits=bits),
          lambda a, w, b: output_neuron([np.int64(v) for v in a], w, b, f),
          f.tansig, f.output_weight, f.output_bias, f.coordinate, np.random.default_rng(inputs))


@pytest.mark.parametrize("bits", MULTIPLIER_BITS)
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.regress)])
def test_hidden_neuron(seed, bits):
    check_hidden(seed, bits)


@pytest.mark.parametrize("inputs,bits", [(1, 27), (8, 27), (3, 18), *(
    pytest.param(*case, marks=pytest.mark.regress) for case in (
        (2, 27), (3, 27), (5, 27), (32, 27), (1, 18), (8, 18)))])
def test_output_neuron(inputs, bits):
    check_output(inputs, bits)


@pytest.mark.parametrize("wrong", WRONG_SATURATIONS)
@pytest.mark.parametrize("check", [check_hidden, lambda: check_output(2)], ids=["hidden", "output"])
def test_finds_a_wrong_saturation(check, wrong, monkeypatch):
    monkeypatch.setattr("ncdc_hdl.neural.neuron.saturate", wrong)
    with pytest.raises(AssertionError, match="Arrays are not equal"):
        check()


@pytest.mark.parametrize("field,change", [("half", -1), ("half", 1), ("bias_shift", -1),
                                          ("bias_shift", 1)])
@pytest.mark.parametrize("check", [check_hidden, lambda: check_output(2)], ids=["hidden", "output"])
def test_finds_a_wrong_constant(check, field, change, monkeypatch):
    right = getattr(WeightedSum, field).fget
    monkeypatch.setattr(WeightedSum, field, property(lambda q: right(q) + change))
    with pytest.raises(AssertionError, match="Arrays are not equal"):
        check()


@pytest.mark.parametrize("neurons", [1, 2, 5, 8, 31, 32])
def test_no_weights_can_make_the_accumulator_wrap(neurons):
    """The most positive and the most negative sum fit the accumulator, and no bit is to spare."""
    for q in (hidden_sum(FORMATS), output_sum(neurons, FORMATS)):
        products = [x * w for x in (q.xq.lo, q.xq.hi) for w in (q.wq.lo, q.wq.hi)]
        most = q.terms * max(products) + (q.bq.hi << q.bias_shift) + q.half
        least = q.terms * min(products) + (q.bq.lo << q.bias_shift) + q.half
        limit = 1 << (q.shape.width - 1)
        assert -limit <= least and limit // 2 <= most < limit


@pytest.mark.parametrize("turns,inputs,bits", [(2, 1, 27), (3, 2, 27), (32, 1, 27), (3, 2, 18)])
def test_output_neuron_in_turns(turns, inputs, bits):
    """Sums over several turns, back to back, with every weight and bias at a limit or random."""
    f, rng = FORMATS, np.random.default_rng(turns)
    dut = OutputNeuron(inputs, f, turns, bits)
    count = 40
    weights = rng.choice([f.output_weight.lo, f.output_weight.hi, 0, 77777], (turns, inputs))
    activations = rng.integers(f.tansig.lo, f.tansig.hi, (count, turns, inputs), endpoint=True)
    activations[0], activations[1] = f.tansig.lo, np.where(weights < 0, f.tansig.lo, f.tansig.hi)
    activations[2] = np.where(weights < 0, f.tansig.hi, f.tansig.lo)
    bias = f.output_bias.hi
    clocks = [(turn, a) for coordinate in activations for turn, a in enumerate(coordinate)]
    clocks.append(clocks[0])       # in which the last weights are there
    previous = 0

    def drive(ctx, item):
        nonlocal previous
        turn, a = item
        ctx.set(dut.first, turn == 0)
        ctx.set(dut.bias, bias)
        for k in range(inputs):
            ctx.set(dut.i[k], int(a[k]))
            ctx.set(dut.weights[k], int(weights[previous][k]))    # they follow one clock later
        previous = turn

    got = np.ravel(run_pipeline(dut, clocks, drive, lambda: [dut.o]))[:-1:turns]
    flat = activations.reshape(count, -1).T
    np.testing.assert_array_equal(got, output_neuron(list(flat), weights.ravel(), bias, f))
    assert f.coordinate.hi in got and len(set(got.tolist())) > 10




@pytest.mark.parametrize("bits", MULTIPLIER_BITS)
def test_one_result_per_clock(bits):
    f, rng = FORMATS, np.random.default_rng(3)
    dut = OutputNeuron(4, f, multiplier_bits=bits)
    weights, bias = rng.integers(-2**20, 2**20, 4), 12345
    inputs = rng.integers(f.tansig.lo, f.tansig.hi, (300, 4))

    def drive(ctx, item):
        ctx.set(dut.bias, bias)
        for k in range(4):
            ctx.set(dut.weights[k], int(weights[k]))
            ctx.set(dut.i[k], int(item[k]))

    got = np.ravel(run_pipeline(dut, list(inputs), drive, lambda: [dut.o]))
    np.testing.assert_array_equal(got, output_neuron(list(inputs.T), weights, bias, f))


def test_rejects_formats_without_rounding():
    with pytest.raises(InputError, match="products Q1.10 x Q4.10 have 20 fraction bits, too few"):
        Formats(input=Q(1, 10), hidden_weight=Q(4, 10), hidden_bias=Q(5, 20), net=Q(5, 20))
