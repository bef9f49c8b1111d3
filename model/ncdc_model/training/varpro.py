"""Levenberg-Marquardt on the hidden layer alone, for many networks in parallel."""

import numpy as np

from ncdc_model.exact import (
    cut,
    eliminate,
    products,
    scale_of,
    slices,
    solve,
    tanh,
    total,
)

__all__ = ["BIAS_LIMIT", "WEIGHT_LIMIT", "Batch"]

# Limits of the descriptor's formats Q4.20 and Q5.27, minus more than their rounding.
WEIGHT_LIMIT = 8 - 2.0**-18
BIAS_LIMIT = 16 - 2.0**-18


class Batch:
    """Networks trained in parallel by bounded Levenberg-Marquardt with variable projection.

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
    precise : bool
        Hidden outputs in two slices of 22 bits (:mod:`ncdc_model.exact`) instead of one:
        for the last step of a training; one is sufficient for the search.
    """

    _STATE = ("theta", "hidden", "gram", "output", "residual", "cost", "damping", "growth")

    def __init__(self, theta, inputs, targets, ridge, skip=False, precise=False):
        self.neurons, self.count = theta.shape[1], 2 if precise else 1
        ones = np.ones((1, inputs.shape[1]))
        # Further terms of the output layer: x, y (skip path), 1.
        linear = np.concatenate([inputs, ones]) if skip else ones
        self.linear = slices(linear, scale_of(linear, 1), self.count)
        self.inputs, self.targets, self.ridge = inputs, targets, ridge * inputs.shape[1]
        self.fan = np.concatenate([inputs, ones])
        self.reach = scale_of(self.fan)
        self.target_slices = slices(targets[None], scale_of(targets), self.count)
        self.limit = np.array([WEIGHT_LIMIT, WEIGHT_LIMIT, BIAS_LIMIT])
        self.theta = np.clip(theta, -self.limit, self.limit)
        self.damping = np.full(len(theta), 1e-2)
        self.growth = np.full(len(theta), 2.0)
        self._start()

    def _start(self):
        """Evaluate the networks."""
        self.hidden, self.gram, self.output, self.residual, self.cost = self._evaluate(self.theta)

    def _hidden(self, theta):
        """Terms of the output layer, as slices (count, S, terms, N)."""
        x, y = self.inputs
        neurons = self.neurons
        hidden = np.empty((self.count, len(theta), neurons + self.linear[0].shape[0], len(x)))
        for part, linear in zip(hidden, self.linear):
            part[:, neurons:] = linear
        net = hidden[0, :, :neurons]
        np.multiply(theta[:, :, 0:1], x, out=net)
        net += theta[:, :, 1:2] * y
        net += theta[:, :, 2:3]
        net *= .5
        for values in net:      # one network at a time stays in the cache
            tanh(values)
        if self.count == 1:
            cut(net, out=net)
        else:
            hidden[:, :, :neurons] = slices(net, 1.0, self.count)
        return hidden

    def _evaluate(self, theta):
        neurons = self.neurons
        hidden = self._hidden(theta)
        gram = products(hidden, hidden)
        diagonal = np.arange(neurons)
        gram[:, diagonal, diagonal] += self.ridge
        output = solve(gram, products(hidden, self.target_slices))
        residual = self.targets - _apply(output, hidden)
        # One step of refinement: the normal equations square the condition number.
        rest = products(hidden, [cut(residual, scale_of(residual, (1, 2)))])
        rest[:, :neurons] -= self.ridge * output[:, :neurons]
        output = output + solve(gram, rest)
        residual = self.targets - _apply(output, hidden)
        cost = _squares(residual) + self.ridge * _squares(output[:, :neurons])
        return hidden, gram, output, residual, cost

    def gauss_newton(self):
        """Descent direction (S, 3 HN), half the cost's negative gradient, and normal matrix."""
        starts, neurons, _ = self.theta.shape
        derivative = np.empty((starts, neurons, 3, self.fan.shape[1]))
        slope = derivative[:, :, 2]
        np.multiply(*[self.hidden[0, :, :neurons]] * 2, out=slope)
        np.subtract(1, slope, out=slope)
        slope *= .5
        for k, values in enumerate(self.fan[:2]):
            np.multiply(slope, values, out=derivative[:, :, k])
        cut(derivative, self.reach, out=derivative)
        derivative = [derivative.reshape(starts, 3 * neurons, -1)]
        weights = np.repeat(self.output[:, :neurons], 3, axis=1)                   # (S, 3 HN, 2)
        residual = [cut(self.residual, scale_of(self.residual, (1, 2)))]
        gradient = total(weights * products(derivative, residual))
        # Kaufman's approximation: derivatives minus their projection on the hidden outputs.
        terms = self.gram.shape[1]
        joint = np.empty((starts, terms + 3 * neurons, terms + 3 * neurons))
        joint[:, :terms, :terms] = self.gram
        joint[:, :terms, terms:] = products(self.hidden, derivative)
        joint[:, terms:, :terms] = joint[:, :terms, terms:].mT
        joint[:, terms:, terms:] = products(derivative, derivative)
        first, second = np.moveaxis(weights, 2, 0)
        return gradient, eliminate(joint, terms) * (first[:, :, None] * first[:, None]
                                                    + second[:, :, None] * second[:, None])

    def run(self, count):
        """``count`` iterations of every network.

        Returns
        -------
        ndarray, shape (count + 1, S)
            Costs before the first iteration and after each.
        """
        costs = [self.cost.copy()]
        for _ in range(count):
            self._step()
            costs.append(self.cost.copy())
        return np.array(costs)

    def _step(self):
        starts, neurons, _ = self.theta.shape
        gradient, normal = self.gauss_newton()
        normal, gradient = self._at_bounds(normal, gradient)
        diagonal = np.arange(3 * neurons)
        scale = normal[:, diagonal, diagonal]
        damped = normal.copy()
        damped[:, diagonal, diagonal] += (self.damping[:, None]
                                          * (scale + 1e-6 * scale.max(1, keepdims=True) + 1e-30))
        move = solve(damped, gradient[:, :, None])[:, :, 0]
        trial = np.clip(self.theta + move.reshape(self.theta.shape), -self.limit, self.limit)
        actual = (trial - self.theta).reshape(starts, -1)
        expected = 2 * total(actual * gradient) - total(total(normal * actual[:, None]) * actual)
        hidden, gram, output, residual, cost = self._evaluate(trial)
        gain = (self.cost - cost) / np.maximum(np.abs(expected), 1e-300)
        better = cost < self.cost
        self._replace(better, trial, hidden, gram, output, residual, cost)
        # Nielsen's rule: shrink by the quality of the quadratic model, grow progressively.
        off = 2 * gain - 1
        shrink = np.clip(1 - off * off * off, 1 / 5, 2)     # a power's last bit may differ
        self.damping = np.clip(np.where(better, self.damping * shrink,
                                        self.damping * self.growth), 1e-10, 1e10)
        self.growth = np.where(better, 2.0, np.minimum(self.growth * 2, 64))

    def _replace(self, better, theta, hidden, gram, output, residual, cost):
        for name, new in (("theta", theta), ("hidden", hidden), ("gram", gram),
                          ("output", output), ("residual", residual), ("cost", cost)):
            old = getattr(self, name)
            if better.all():
                setattr(self, name, new)
            elif name == "hidden":
                old[:, better] = new[:, better]
            else:
                old[better] = new[better]

    def _at_bounds(self, normal, gradient):
        # A parameter at its bound whose gradient points outwards is fixed.
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
        """Drop all but the ``count`` networks of lowest cost."""
        self._select(np.argsort(self.cost, kind="stable")[:count])

    def keep_different(self, count):
        """As :meth:`keep`, but only the best of the networks at one minimum remains."""
        order = np.argsort(self.cost, kind="stable")
        cost = self.cost[order]
        fresh = np.concatenate([[True], cost[1:] > cost[:-1] * (1 + 1e-4)])
        self._select(order[fresh][:count])

    def join(self, other):
        """Add the networks of the batch ``other``, trained on the same points."""
        for name in self._STATE:
            axis = 1 if name == "hidden" else 0
            setattr(self, name, np.concatenate([getattr(self, name), getattr(other, name)], axis))

    def _select(self, which):
        for name in self._STATE:
            setattr(self, name, np.take(getattr(self, name), which, 1 if name == "hidden" else 0))


def _squares(values):
    """Sums (S,) of the squares of ``values`` (S, n, m)."""
    return total((values**2).reshape(len(values), -1))


def _apply(output, hidden):
    """Network outputs (S, 2, N) of (S, terms, 2) and slices (S, terms, N)."""
    wanted = slices(output.mT, scale_of(output, (1, 2)), 2)
    return products(wanted, [part.mT for part in hidden])
