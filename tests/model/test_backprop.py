"""Error back-propagation: equations (15)-(22) pattern by pattern, stopping rules, divergence."""

import numpy as np
import pytest

from lenses import GEOMETRY, equidistant
from ncdc_model.training.backprop import BackPropagation, Stop, train_backprop
from ncdc_model.training.problem import Problem, errors_of
from ncdc_spec.errors import InputError
from reference_lenses import reference_lens


def coarse_problem():
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(4, 315, 9), np.linspace(4, 235, 7)))
    return Problem(u, v, *equidistant(u, v), GEOMETRY)


def half_square(hidden, output, pattern, target):
    """Half the squared error of one network on one pattern, straight from (15)-(18)."""
    n = hidden @ pattern
    a = np.append(2 / (1 + np.exp(-n)) - 1, 1)
    return .5 * ((target - output @ a)**2).sum()


def test_change_of_one_pattern_is_the_negative_gradient_times_the_rate():
    random = np.random.default_rng(1)
    hidden, output = random.uniform(-1, 1, (3, 4, 3)), random.uniform(-1, 1, (3, 2, 5))
    pattern, target = np.array([.3, -.7, 1]), np.array([.9, -.4])
    rates = np.array([.05, .2, .5])
    networks = BackPropagation(hidden, output, rates)
    networks.learn(pattern[:, None], target[:, None])
    for run in range(3):
        for layer, before, after in ((0, hidden, networks.hidden), (1, output, networks.output)):
            for index in np.ndindex(before.shape[1:]):
                errors = []
                for sign in (1, -1):
                    layers = [hidden[run].copy(), output[run].copy()]
                    layers[layer][index] += sign * 1e-6
                    errors.append(half_square(*layers, pattern, target))
                slope = (errors[0] - errors[1]) / 2e-6
                change = after[run][index] - before[run][index]
                assert change == pytest.approx(-rates[run] * slope, rel=1e-5, abs=1e-9)


def test_runs_side_by_side_do_not_touch_each_other():
    random = np.random.default_rng(2)
    hidden, output = random.uniform(-1, 1, (2, 3, 3)), random.uniform(-1, 1, (2, 2, 4))
    together = BackPropagation(hidden, output, [.1, .3])
    alone = [BackPropagation(hidden[k:k + 1], output[k:k + 1], [rate])
             for k, rate in enumerate((.1, .3))]
    for _ in range(50):
        pattern = np.append(random.uniform(-1, 1, 2), 1)[:, None]
        target = random.uniform(-1, 1, (2, 1))
        for networks in (together, *alone):
            networks.learn(pattern, target)
    for k in range(2):
        np.testing.assert_allclose(together.hidden[k], alone[k].hidden[0], rtol=1e-12)
        np.testing.assert_allclose(together.output[k], alone[k].output[0], rtol=1e-12)


def test_learns_the_lens_and_reports_pixels():
    problem = coarse_problem()
    network, curve = train_backprop(problem, 4, runs=4, stop=Stop(epochs=400))
    assert curve[-1][1] == pytest.approx(errors_of(network, problem)["mse"])
    affine = np.linalg.lstsq(np.c_[problem.inputs.T, np.ones(len(problem))], problem.targets.T,
                             rcond=None)[1].sum() / len(problem)
    assert curve[-1][1] < affine / 5
    assert all(a[1] > b[1] and a[0] < b[0] for a, b in zip(curve, curve[1:]))


def test_same_seed_same_network():
    problem = coarse_problem()
    first, again, other = (train_backprop(problem, 3, seed=s, runs=2, stop=Stop(epochs=5))[0]
                           for s in (4, 4, 5))
    assert first.hidden_weights.tobytes() == again.hidden_weights.tobytes()
    assert first.hidden_weights.tobytes() != other.hidden_weights.tobytes()


def test_stops_at_the_target():
    problem = coarse_problem()
    _, long = train_backprop(problem, 3, runs=2, stop=Stop(epochs=60))
    goal = long[len(long) // 2]
    _, curve = train_backprop(problem, 3, runs=2,
                              stop=Stop(epochs=60, target_mse=goal[1]))
    assert curve[-1] == goal


def test_stops_without_improvement():
    seen = []
    train_backprop(coarse_problem(), 3, runs=2, rates=(1e-9,), stop=Stop(epochs=500, patience=7),
                   progress=lambda done, mse: seen.append(done))
    assert len(seen) == 8


def test_divergence_is_named():
    with pytest.raises(InputError, match="diverged at every learning rate of 50; give a smaller"):
        train_backprop(coarse_problem(), 3, runs=2, rates=(50.,), stop=Stop(epochs=50))


@pytest.mark.longer
def test_approaches_the_optimum_of_levenberg_on_the_papers_lens_class():
    dots, dense = reference_lens("PC105")
    network, _ = train_backprop(dots, 4, runs=4, rates=(.2,), stop=Stop(epochs=250))
    assert errors_of(network, dense)["mse"] < 8
