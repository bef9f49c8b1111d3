"""Levenberg-Marquardt on the hidden layer alone, many networks side by side."""

import numpy as np

__all__ = ["BIAS_LIMIT", "WEIGHT_LIMIT", "Batch"]

# Inside the formats Q4.20 and Q5.27 of the descriptor by more than their rounding.
WEIGHT_LIMIT = 8 - 2.0**-18
BIAS_LIMIT = 16 - 2.0**-18


class Batch:
    """Networks trained side by side by bounded Levenberg-Marquardt with variable projection.

    Equations (15)-(18) of the paper with gamma = 1. For given hidden neurons the linear output
    layer is the solution of a least-squares problem, so that only the hidden weights and biases
    are searched, within :data:`WEIGHT_LIMIT` and :data:`BIAS_LIMIT`. The cost is the sum of
    squared errors plus ``ridge`` * N * the sum of squared output weights. With ``skip`` the inputs
    themselves are further terms of the linear output layer, without a ridge.

    Parameters
    ----------
    theta : ndarray, shape (S, HN, 3)
        Weights of x and y and bias of every hidden neuron of every network.
    inputs, targets : ndarray, shape (2, N)
        Both about -1..1.
    ridge : float
    skip : bool
    """

    _STATE = ("theta", "hidden", "gram", "output", "residual", "cost", "damping", "growth")

    def __init__(self, theta, inputs, targets, ridge, skip=False):
        self.neurons = theta.shape[1]
        ones = np.ones((1, inputs.shape[1]))
        # What the output layer sums besides the hidden outputs: x, y (skip path), 1.
        self.linear = np.concatenate([inputs, ones]) if skip else ones
        self.inputs, self.targets, self.ridge = inputs, targets, ridge * inputs.shape[1]
        self.limit = np.array([WEIGHT_LIMIT, WEIGHT_LIMIT, BIAS_LIMIT])
        self.theta = np.clip(theta, -self.limit, self.limit)
        self.damping = np.full(len(theta), 1e-2)
        self.growth = np.full(len(theta), 2.0)
        self.hidden, self.gram, self.output, self.residual, self.cost = self._evaluate(self.theta)

    def _evaluate(self, theta):
        x, y = self.inputs
        neurons = self.neurons
        hidden = np.empty((len(theta), neurons + len(self.linear), len(x)))
        hidden[:, neurons:] = self.linear
        net = hidden[:, :neurons]
        np.multiply(theta[:, :, 0:1], x, out=net)
        net += theta[:, :, 1:2] * y
        net += theta[:, :, 2:3]
        net *= .5
        np.tanh(net, out=net)
        gram = _products(hidden, hidden)
        diagonal = np.arange(neurons)
        gram[:, diagonal, diagonal] += self.ridge
        output = np.linalg.solve(gram, _products(hidden, self.targets[None]))
        residual = self.targets - _apply(output, hidden)
        # One step of refinement: the normal equations square the condition number.
        rest = _products(hidden, residual)
        rest[:, :neurons] -= self.ridge * output[:, :neurons]
        output = output + np.linalg.solve(gram, rest)
        residual = self.targets - _apply(output, hidden)
        cost = (residual**2).sum((1, 2)) + self.ridge * (output[:, :neurons]**2).sum((1, 2))
        return hidden, gram, output, residual, cost

    def gauss_newton(self):
        """Descent direction (S, 3 HN), half the cost's negative gradient, and normal matrix."""
        starts, neurons, _ = self.theta.shape
        active = self.hidden[:, :neurons]
        slope = .5 * (1 - active**2)
        fan = np.concatenate([self.inputs, np.ones((1, self.inputs.shape[1]))])
        derivative = (slope[:, :, None, :] * fan).reshape(starts, 3 * neurons, -1)
        weights = np.repeat(self.output[:, :neurons], 3, axis=1)                   # (S, 3 HN, 2)
        gradient = (weights * _products(derivative, self.residual)).sum(2)
        # Kaufman's approximation: derivatives less their projection on the hidden outputs.
        mixed = _products(self.hidden, derivative)
        normal = _products(derivative, derivative) - mixed.mT @ np.linalg.solve(self.gram, mixed)
        normal *= weights @ weights.mT
        return gradient, normal

    def step(self):
        """One iteration of every network; returns which of them improved, shape (S,)."""
        starts, neurons, _ = self.theta.shape
        gradient, normal = self.gauss_newton()
        normal, gradient = self._at_bounds(normal, gradient)
        diagonal = np.arange(3 * neurons)
        scale = normal[:, diagonal, diagonal]
        damped = normal.copy()
        damped[:, diagonal, diagonal] += (self.damping[:, None]
                                          * (scale + 1e-6 * scale.max(1, keepdims=True) + 1e-30))
        move = np.linalg.solve(damped, gradient[:, :, None])[:, :, 0]
        trial = np.clip(self.theta + move.reshape(self.theta.shape), -self.limit, self.limit)
        actual = (trial - self.theta).reshape(starts, -1)
        expected = (2 * (actual * gradient).sum(1)
                    - (actual[:, None, :] @ normal @ actual[:, :, None])[:, 0, 0])
        hidden, gram, output, residual, cost = self._evaluate(trial)
        gain = (self.cost - cost) / np.maximum(np.abs(expected), 1e-300)
        better = cost < self.cost
        self._replace(better, trial, hidden, gram, output, residual, cost)
        # Nielsen's rule: shrink by how well the quadratic model predicted, grow ever faster.
        shrink = np.clip(1 - (2 * gain - 1)**3, 1 / 5, 2)
        self.damping = np.clip(np.where(better, self.damping * shrink,
                                        self.damping * self.growth), 1e-10, 1e10)
        self.growth = np.where(better, 2.0, np.minimum(self.growth * 2, 64))
        return better

    def _replace(self, better, theta, hidden, gram, output, residual, cost):
        for name, new in (("theta", theta), ("hidden", hidden), ("gram", gram),
                          ("output", output), ("residual", residual), ("cost", cost)):
            old = getattr(self, name)
            if better.all():
                setattr(self, name, new)
            else:
                old[better] = new[better]

    def _at_bounds(self, normal, gradient):
        # A parameter at its bound that wants to go further is held.
        flat = self.theta.reshape(len(self.theta), -1)
        limit = np.tile(self.limit, self.theta.shape[1])
        held = (np.abs(flat) >= limit) & (gradient * flat > 0)
        if held.any():
            normal = np.where(held[:, :, None] | held[:, None, :], 0, normal)
            index = np.arange(flat.shape[1])
            normal[:, index, index] += held
            gradient = np.where(held, 0, gradient)
        return normal, gradient

    def keep(self, count):
        """Drop all but the ``count`` networks of least cost."""
        self._select(np.argsort(self.cost, kind="stable")[:count])

    def keep_different(self, count):
        """As :meth:`keep`, but of networks that reached one minimum only the best stays."""
        order = np.argsort(self.cost, kind="stable")
        cost = self.cost[order]
        fresh = np.concatenate([[True], cost[1:] > cost[:-1] * (1 + 1e-4)])
        self._select(order[fresh][:count])

    def join(self, other):
        """Take in the networks of the batch ``other``, trained on the same points."""
        for name in self._STATE:
            setattr(self, name, np.concatenate([getattr(self, name), getattr(other, name)]))

    def _select(self, which):
        for name in self._STATE:
            setattr(self, name, getattr(self, name)[which])


def _products(a, b):
    """Sums over the last axis, a @ b.mT, of stacks (S, m, N) and (S or 1, n, N).

    In blocks so small that the linear algebra library never splits one over its threads: the
    result must not depend on their number.
    """
    block = max(8, 60000 // (a.shape[1] * b.shape[1]))
    total = 0
    for start in range(0, a.shape[2], block):
        total = total + a[:, :, start:start + block] @ b[:, :, start:start + block].mT
    return total


def _apply(output, hidden):
    """Network outputs (S, 2, N), in blocks for the reason of :func:`_products`."""
    block = max(8, 60000 // (2 * hidden.shape[1]))
    return np.concatenate([output.mT @ hidden[:, :, start:start + block]
                           for start in range(0, hidden.shape[2], block)], axis=2)
