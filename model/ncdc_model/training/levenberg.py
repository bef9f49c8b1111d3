"""Default trainer: bounded Levenberg-Marquardt from many starts, with variable projection."""

import numpy as np

from ncdc_model.training.compiled_batch import batch_kind
from ncdc_model.training.problem import spread
from ncdc_spec.descriptor import FloatNetwork

__all__ = ["train_levenberg"]

OUTPUT_LIMIT = 2047.0              # pixels, Q12.12
LINEAR_LIMIT = 8191.0              # pixels, of biases and skip weights, Q14
RIDGE = 2e-10                      # limits output weights to about 1000 pixels, costs < 1 % in MSE
SEARCH_POINTS = 700                # the search uses a subset, the polish every point
_POLISHES, _POLISH = 20, 10        # times so many iterations of the polish, at most


def train_levenberg(problem, neurons, seed=0, starts=64, rounds=6, skip=False, progress=None):
    """Network of minimum squared error on the pairs of ``problem``, and its learning curve.

    Equations (15)-(18) of the paper, gamma = 1, trained by Levenberg-Marquardt instead of error
    back-propagation. For given hidden neurons the linear output layer is a least-squares solution,
    so that only the hidden weights and biases are searched (variable projection), within the limits
    of ``varpro``. The search has three kinds of start: random ones, the best network with one
    neuron less plus a random neuron, and good networks with one neuron replaced by a random one.
    The best is refined on all pairs.

    Parameters
    ----------
    problem : Problem
    neurons : int
        Hidden neurons HN.
    seed : int
        The same seed gives the same network, bit for bit, with any library and number of threads.
    starts : int
        Random starts.
    rounds : int
        Rounds of replacing neurons.
    skip : bool
        With a linear path from the inputs directly to the outputs.
    progress : callable, optional
        Called with (fraction done, MSE in px^2 so far).

    Returns
    -------
    network : FloatNetwork
    curve : list of (int, float)
        Iterations over all starts, and the best MSE in px^2 up to there.

    Raises
    ------
    InputError
        If the pairs are too few.
    """
    problem.check(neurons)
    search = _Search(problem, seed, starts, rounds, skip, progress)
    return search.run(neurons)


class _Search:
    def __init__(self, problem, seed, starts, rounds, skip, progress):
        self.random, self.skip, self.batch = np.random.default_rng(seed), skip, batch_kind()
        self.starts, self.rounds, self.progress = starts, rounds, progress
        self.inputs, targets = problem.inputs, problem.targets
        self.offset = targets.mean(1)
        self.scale = max(problem.geometry.distorted) / 2
        self.targets = (targets - self.offset[:, None]) / self.scale
        self.subset = spread(len(problem), SEARCH_POINTS)
        self.iterations, self.curve, self.done = 0, [], 0.0

    def run(self, neurons):
        """Best network with ``neurons`` and the learning curve."""
        smaller = None
        first = max(1, neurons - 2)
        for size in range(first, neurons + 1):
            last = size == neurons
            starts, rounds = (self.starts, self.rounds) if last else (self.starts // 3,
                                                                      (self.rounds + 1) // 3)
            share = (.8 if last else .2 / (neurons - first)) / (1 + rounds)
            # In larger networks random starts find less, and grown ones more.
            theta = self._random(starts if size <= 8 else starts // 2, size)
            if smaller is not None:
                theta = np.concatenate([theta, self._grown(smaller, self.starts // 3)])
            best = self._descend(theta, share)
            for _ in range(rounds):
                best = self._descend(self._redrawn(best, self.starts // 3), share, best)
            smaller = best
        return self._polish(best)

    def _random(self, count, neurons):
        # Ridges of random direction and steepness through random points, and uniform parameters.
        shape = (count // 2, neurons)
        angle, steep = self.random.uniform(0, 2 * np.pi, shape), self.random.uniform(.5, 2, shape)
        w = np.stack([steep * np.cos(angle), steep * np.sin(angle)], axis=-1)
        point = self.random.uniform(-1.2, 1.2, w.shape)
        ridges = np.concatenate([w, -(w * point).sum(2, keepdims=True)], axis=2)
        reach = self.random.choice([1.0, 3.0], (count - count // 2, 1, 1))
        uniform = reach * self.random.uniform(-1, 1, (len(reach), neurons, 3))
        return np.concatenate([ridges, uniform])

    def _grown(self, batch, count):
        source = batch.theta[np.arange(count) % len(batch.theta)]
        return np.concatenate([source, self._random(count, 1)], axis=1)

    def _redrawn(self, batch, count):
        # Copy k of a network has its neuron k replaced by a random one.
        theta = batch.theta[np.arange(count) % len(batch.theta)].copy()
        which = (np.arange(count) // len(batch.theta)
                 + self.random.integers(theta.shape[1])) % theta.shape[1]
        theta[np.arange(count), which] = self._random(count, 1)[:, 0]
        return theta

    def _descend(self, theta, share, rivals=None):
        """Successive halving of the starts ``theta``; the survivors and ``rivals``, best first."""
        batch = self.batch(theta, self.inputs[:, self.subset], self.targets[:, self.subset], RIDGE,
                           self.skip)
        stages = ((25, .4), (50, .4), (100, .5), (150, .5))
        for iterations, part in stages:
            for costs in batch.run(iterations)[1:]:
                self.iterations += len(costs)
                self._record(costs.min())
            batch.keep(max(4, int(len(batch.cost) * part)))
        if rivals is not None:
            batch.join(rivals)
        batch.keep_different(4)
        self.done += share
        if self.progress:
            self.progress(min(self.done, 1.0), self.curve[-1][1])
        return batch

    def _record(self, cost):
        mse = float(cost / len(self.subset) * self.scale**2)
        if not self.curve or mse < self.curve[-1][1]:
            self.curve.append((self.iterations, mse))

    def _polish(self, batch):
        ridge = RIDGE
        while True:
            final = self.batch(batch.theta, self.inputs, self.targets, ridge, self.skip,
                               precise=True)
            for _ in range(_POLISHES):
                costs = final.run(_POLISH)
                if (costs[-2] == costs[-1]).all() and (final.damping > 1e3).all():
                    break
            for k in np.argsort(final.cost, kind="stable"):
                network = self._network(final, k)
                linear = [network.output_biases] + ([network.skip_weights] if self.skip else [])
                if (np.abs(network.output_weights).max() < OUTPUT_LIMIT
                        and max(np.abs(part).max() for part in linear) < LINEAR_LIMIT):
                    weights = (final.output[k, :final.neurons]**2).sum()
                    mse = float((final.cost[k] - final.ridge * weights) / self.inputs.shape[1]
                                * self.scale**2)
                    self.curve.append((self.iterations, mse))
                    if self.progress:
                        self.progress(1.0, mse)
                    return network, self.curve
            ridge *= 100

    def _network(self, batch, k):
        theta, neurons = batch.theta[k], batch.neurons
        output = batch.output[k] * self.scale
        return FloatNetwork(theta[:, :2].copy(), theta[:, 2].copy(), output[:neurons].T.copy(),
                            output[-1] + self.offset,
                            skip_weights=output[neurons:-1].T.copy() if self.skip else None)
