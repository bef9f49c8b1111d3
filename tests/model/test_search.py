"""The compiled search of the training, with the reference's bits."""

import numpy as np
import pytest

from lenses import lens_problem
from ncdc_model import exact
from ncdc_model.training import levenberg
from ncdc_model.training.compiled_batch import CompiledBatch, batch_kind
from ncdc_model.training.levenberg import train_levenberg
from ncdc_model.training.varpro import Batch


def test_tanh_is_that_of_double_precision():
    values = np.concatenate([np.random.default_rng(1).uniform(-25, 25, 5000),
                             [0, 1e-300, -1e-9, 1 / 64, -1 / 64, 19.99, 20, 300, -300]])
    found = exact.tanh(values.copy())
    assert np.abs(found - np.tanh(values)).max() < 2.0**-51
    small = np.abs(values) < .1
    np.testing.assert_allclose(found[small], np.tanh(values[small]), rtol=2.0**-51)


def test_total_adds_halves():
    values = np.random.default_rng(2).normal(size=(3, 37))
    np.testing.assert_allclose(exact.total(values), values.sum(1), rtol=1e-12)
    a, b, c = 1e16, 1., -1e16
    assert exact.total(np.array([a, b, c])) == (a + c) + b != a + b + c


@pytest.mark.parametrize("neurons,points,skip,precise", [
    (1, 37, False, False), (4, 700, True, False), (3, 1100, False, True), (5, 2500, True, True),
    (32, 120, False, False)])
def test_compiled_steps_have_the_bits_of_the_reference(neurons, points, skip, precise):
    # More than 1024 points are summed in blocks; networks of large weights meet their limits.
    random = np.random.default_rng(neurons)
    inputs = random.uniform(-1, 1, (2, points))
    targets = np.stack([np.tanh(inputs[0] * 1.3 + inputs[1]**2), inputs[0] * np.sin(inputs[1])])
    theta = random.uniform(-3, 3, (5, neurons, 3)) * [[[1]], [[1]], [[1]], [[1]], [[6]]]
    batches = [kind(theta, inputs, targets, 2e-10, skip, precise)
               for kind in (Batch, CompiledBatch)]
    for count in (2, 25):
        for name in CompiledBatch._STATE:
            np.testing.assert_array_equal(*(getattr(batch, name) for batch in batches), name)
        np.testing.assert_array_equal(*(batch.run(count) for batch in batches))
        for batch in batches:
            batch.keep(4)
    assert batches[0].cost.min() < Batch(theta, inputs, targets, 2e-10, skip).cost.min()


def test_a_network_that_is_stuck_stays():
    # The damping and its growth reach their limits: the compiled search stops computing.
    inputs = np.random.default_rng(3).uniform(-1, 1, (2, 30))
    batches = [kind(np.full((1, 1, 3), .5), inputs, np.zeros((2, 30)), 2e-10)
               for kind in (Batch, CompiledBatch)]
    costs = [batch.run(60) for batch in batches]
    np.testing.assert_array_equal(*costs)
    assert batches[1].damping == 1e10 == batches[0].damping
    assert batches[1].growth == 64 == batches[0].growth


@pytest.mark.longer
def test_training_gives_the_same_network_with_either(monkeypatch):
    assert batch_kind() is CompiledBatch
    problem, networks = lens_problem(14, 10), []
    for kind in (Batch, CompiledBatch):
        monkeypatch.setattr(levenberg, "batch_kind", lambda kind=kind: kind)
        networks.append(train_levenberg(problem, 4, starts=12, rounds=1))
    (first, curve), (second, other) = networks
    assert curve == other
    for name in ("hidden_weights", "hidden_biases", "output_weights", "output_biases"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_the_reference_is_taken_where_it_is_asked_for(monkeypatch):
    monkeypatch.setenv("NCDC_MODEL", "reference")
    assert batch_kind() is Batch
