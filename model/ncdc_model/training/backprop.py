"""The paper's trainer: error back-propagation, one pattern after the other."""

from dataclasses import dataclass

import numpy as np

from ncdc_spec.descriptor import FloatNetwork
from ncdc_spec.errors import InputError

__all__ = ["BackPropagation", "Stop", "train_backprop"]


@dataclass(frozen=True)
class Stop:
    """Conditions to end back-propagation; the first that holds ends it.

    Parameters
    ----------
    epochs : int
        Passes over the pairs, at most.
    target_mse : float
        A network's MSE is at most this, in px^2.
    patience : int
        The best MSE has not fallen by 0.1 % in as many epochs.
    """
    epochs: int = 5000
    target_mse: float = 0.0
    patience: int = 1000


class BackPropagation:
    """Networks trained in parallel by equations (15)-(22) of the paper, gamma = 1.

    (21) multiplies by the output of the neuron itself, a misprint; this multiplies by the neuron's
    input. All errors are computed before a weight changes.

    Parameters
    ----------
    hidden : ndarray, shape (R, HN, 3)
        Weights of x and y and bias of each hidden neuron of each network.
    output : ndarray, shape (R, 2, HN + 1)
        Weights and bias of each output neuron.
    rates : ndarray, shape (R,)
        Learning rate of each network.
    """

    def __init__(self, hidden, output, rates):
        runs, neurons, _ = hidden.shape
        self.hidden, self.output = hidden.copy(), output.copy()
        self._rates = np.asarray(rates, np.float64)[:, None, None]
        self._a = np.ones((runs, neurons + 1, 1))
        self._row = self._a.transpose(0, 2, 1)
        self._active = self._a[:, :-1]
        self._back = self.output[:, :, :-1].transpose(0, 2, 1)
        self._terms = np.empty_like(hidden), np.empty_like(output), np.empty((runs, neurons, 2))
        self._n, self._slope, self._delta = (np.empty((runs, neurons, 1)) for _ in range(3))
        self._error = np.empty((runs, 2, 1))
        self._change_hidden, self._change_output = np.empty_like(hidden), np.empty_like(output)

    def learn(self, pattern, target):
        """Change every weight for one pattern; return its previous errors, shape (R, 2, 1).

        ``pattern``: x, y, 1 as (3, 1); ``target``: (2, 1). The next call overwrites the
        result.
        """
        # (15)-(18): feed-forward; f(n) = tanh(n / 2).
        _product(self.hidden, pattern[:, 0], self._terms[0], self._n)
        np.multiply(self._n, .5, out=self._n)
        np.tanh(self._n, out=self._active)
        _product(self.output, self._row, self._terms[1], self._error)
        # (19): error of the output layer, whose gradient (20) is the error itself.
        np.subtract(target, self._error, out=self._error)
        # (19), (20): error of the hidden layer through the output weights, times f'(n).
        _product(self._back, self._error.transpose(0, 2, 1), self._terms[2], self._delta)
        np.multiply(self._active, self._active, out=self._slope)
        np.subtract(1, self._slope, out=self._slope)
        np.multiply(self._slope, .5, out=self._slope)
        np.multiply(self._delta, self._slope, out=self._delta)
        # (21), (22): both layers.
        np.multiply(self._delta, self._rates, out=self._delta)
        np.multiply(self._delta, pattern[:, 0], out=self._change_hidden)
        np.multiply(self._error, self._row, out=self._change_output)
        np.multiply(self._change_output, self._rates, out=self._change_output)
        np.add(self.hidden, self._change_hidden, out=self.hidden)
        np.add(self.output, self._change_output, out=self.output)
        return self._error

    def errors(self, patterns, targets):
        """Sum of squared errors of each network over (3, N) patterns, (2, N) targets."""
        total = np.zeros(len(self.hidden))
        for run, (hidden, output) in enumerate(zip(self.hidden, self.output)):
            wx, wy, bias = hidden.T[:, :, None]
            a = np.tanh((wx * patterns[0] + wy * patterns[1] + bias) / 2)
            for target, row in zip(targets, output):
                result = np.full(len(target), row[-1])
                for weight, activation in zip(row, a):
                    result += weight * activation
                total[run] += ((target - result)**2).sum()
        return total


def _product(matrix, row, terms, out):
    """Matrix times vector, the vector as a row; without the BLAS, whose sums differ by machine."""
    np.multiply(matrix, row, out=terms)
    np.add.reduce(terms, axis=2, keepdims=True, out=out)


def train_backprop(problem, neurons, seed=0, progress=None, runs=8, rates=(.05, .2), stop=Stop()):
    """Best of several networks trained by error back-propagation, and its learning curve.

    Equations (15)-(22) of the paper with gamma = 1 and no momentum. Initial weights and biases
    are uniform in -1..1, distorted coordinates are normalised to -1..1 of the image. The
    patterns have a new random order in every epoch. The result has the weights of the best epoch.

    Parameters
    ----------
    problem : Problem
    neurons : int
    seed : int
    progress : callable, optional
        Called with (fraction of the epochs done, MSE in px^2 so far).
    runs : int
        Networks trained in parallel from different weights.
    rates : sequence of float
        Learning rates, assigned to the runs in turn.
    stop : Stop

    Returns
    -------
    network : FloatNetwork
    curve : list of (int, float)
        Epoch, and the best MSE over the pairs up to there, px^2.

    Raises
    ------
    InputError
        If the pairs are too few, or every run diverges.
    """
    problem.check(neurons)
    random = np.random.default_rng(seed)
    size = np.array([problem.geometry.distorted]).T
    centre, scale = (size - 1) / 2, size / 2
    targets = (problem.targets - centre) / scale
    networks = BackPropagation(random.uniform(-1, 1, (runs, neurons, 3)),
                               random.uniform(-1, 1, (runs, 2, neurons + 1)),
                               np.resize(np.asarray(rates, np.float64), runs))
    with np.errstate(all="ignore"):
        best, curve = _epochs(networks, problem, (targets, scale), random, stop,
                              progress or (lambda done, mse: None))
    if best is None:
        raise InputError(f"error back-propagation diverged at every learning rate of "
                         f"{', '.join(f'{rate:g}' for rate in rates)}; give a smaller one")
    hidden, output = best
    return FloatNetwork(hidden[:, :2].copy(), hidden[:, 2].copy(), output[:, :-1] * scale,
                        output[:, -1] * scale[:, 0] + centre[:, 0]), curve


def _epochs(networks, problem, normalised, random, stop, progress):
    """Train all epochs: (hidden, output) weights of the best network or None, learning curve.

    ``normalised``: the targets that the networks learn, and pixels per unit of each axis.
    """
    targets, scale = normalised
    patterns = np.concatenate([problem.inputs, np.ones((1, len(problem)))])
    # One MSE in pixels needs the scale of each axis as weight of the squared errors.
    pixels = patterns, targets * scale
    diverged = 1e3 * (_in_pixels(networks, scale).errors(*pixels) / len(problem)).max()
    best, curve, last, watched = None, [], 0, np.inf
    each = np.ascontiguousarray(patterns.T[:, :, None]), np.ascontiguousarray(targets.T[:, :, None])
    for epoch in range(1, stop.epochs + 1):
        for k in random.permutation(len(problem)):
            networks.learn(each[0][k], each[1][k])
        mse = _in_pixels(networks, scale).errors(*pixels) / len(problem)
        mse[~(mse < diverged)] = np.inf
        k = int(mse.argmin())
        if mse[k] < (curve[-1][1] if curve else np.inf):
            best = networks.hidden[k].copy(), networks.output[k].copy()
            curve.append((epoch, float(mse[k])))
            if mse[k] < .999 * watched:
                last, watched = epoch, mse[k]
        progress(epoch / stop.epochs, curve[-1][1] if curve else float("inf"))
        if curve and (curve[-1][1] <= stop.target_mse or epoch - last >= stop.patience):
            break
        if not np.isfinite(mse).any():
            break
    return best, curve


def _in_pixels(networks, scale):
    return BackPropagation(networks.hidden, networks.output * scale, np.ones(len(networks.hidden)))
