"""Neurons: gateware compared with the golden model, over every rounding and saturation edge."""

import pytest

from ncdc_hdl.neural.neuron import HiddenNeuron, OutputNeuron, WeightedSum, hidden_sum, output_sum
from ncdc_spec.descriptor import Formats
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.hardware import MULTIPLIER_BITS
from saturations import WRONG_SATURATIONS
from units.neurons import check_hidden_neuron, check_output_neuron

FORMATS = Formats()


def check_hidden(bits=27):
    check_hidden_neuron(HiddenNeuron(FORMATS, bits), FORMATS)


def check_output(inputs, turns=1, bits=27):
    check_output_neuron(OutputNeuron(inputs, FORMATS, turns, bits), FORMATS)


@pytest.mark.parametrize("bits", MULTIPLIER_BITS)
def test_hidden_neuron(bits):
    check_hidden(bits)


@pytest.mark.parametrize("inputs,turns,bits", [(1, 1, 27), (8, 1, 27), (3, 1, 18), (1, 2, 27),
                                               (2, 3, 18), *(
    pytest.param(*case, marks=pytest.mark.regress) for case in (
        (2, 1, 27), (3, 1, 27), (5, 1, 27), (32, 1, 27), (1, 1, 18), (8, 1, 18), (2, 3, 27),
        (1, 32, 27)))])
def test_output_neuron(inputs, turns, bits):
    """Back to back, one coordinate in as many clocks as there are turns."""
    check_output(inputs, turns, bits)


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


def test_rejects_formats_without_rounding():
    with pytest.raises(InputError, match="products Q1.10 x Q4.10 have 20 fraction bits, too few"):
        Formats(input=Q(1, 10), hidden_weight=Q(4, 10), hidden_bias=Q(5, 20), net=Q(5, 20))
