"""The output layer in turns: each coordinate from its activations, whatever fills the gaps."""

import numpy as np
import pytest

from banks import bank_words, take_bank, write_bank
from ncdc_hdl.neural.layers import OutputLayer, served
from ncdc_model.golden.network import output_neuron
from ncdc_spec.descriptor import Formats
from pipelines import run_pipeline

F = Formats()


@pytest.mark.parametrize("neurons,share", [
    (1, 1), (8, 1), (2, 2), (5, 4), (8, 3), (31, 8), (32, 32)])
@pytest.mark.parametrize("gap", [0, 2])
def test_output_layer(neurons, share, gap):
    """Turns without a neuron, and ``gap`` clocks between coordinates, hold random values."""
    rng, count = np.random.default_rng(neurons), 20
    dut = OutputLayer(neurons, F, share)
    q = F.tansig
    activations = rng.integers(q.lo, q.hi, (count, neurons), endpoint=True)
    weights = rng.integers(F.output_weight.lo, F.output_weight.hi, (2, neurons)) >> 3
    biases = rng.integers(F.output_bias.lo, F.output_bias.hi, 2) >> 3
    clocks = rng.integers(q.lo, q.hi, (count, share + gap, dut.units), endpoint=True)
    for unit in range(dut.units):
        for turn, j in enumerate(served(unit, neurons, share)):
            clocks[:, turn, unit] = activations[:, j]
    items = [(turn == 0, a) for coordinate in clocks for turn, a in enumerate(coordinate)]

    def drive(ctx, item):
        ctx.set(dut.first, int(item[0]))
        for unit, value in enumerate(item[1]):
            ctx.set(dut.i[unit], int(value))
        for k in range(2):
            parallel = {"weights": weights[k].tolist()} if share == 1 else {}
            ctx.set(dut.neurons[k], {"bias": int(biases[k])} | parallel)

    async def prepare(ctx):
        if share > 1:
            await write_bank(ctx, dut.writes, bank_words([], [], weights))
            take_bank(ctx, dut.writes)

    got = np.array(run_pipeline(dut, items, drive, lambda: list(dut.o), prepare))[::share + gap]
    for k in range(2):
        expected = output_neuron(list(activations.T), weights[k], biases[k], F)
        np.testing.assert_array_equal(got[:, k], expected)
        assert len(set(expected.tolist())) > 10
