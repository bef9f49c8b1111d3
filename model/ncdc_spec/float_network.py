"""The network in real numbers, as it is trained."""

import math
from dataclasses import dataclass, replace

import numpy as np

from ncdc_spec.errors import InputError

__all__ = ["FloatNetwork", "check_gamma"]


def check_gamma(gamma):
    """``gamma`` as a float; raises InputError if it is not a positive number."""
    if isinstance(gamma, bool) or not (math.isfinite(gamma) and gamma > 0):
        raise InputError(f"gamma is {gamma}, a positive number is needed")
    return float(gamma)


@dataclass(frozen=True)
class FloatNetwork:
    """The network in real numbers: 2 inputs, HN tan-sigmoid neurons, 2 linear outputs in pixels.

    Equations (15)-(18) of the paper::

        n[j] = hidden_weights[j] . (x, y) + hidden_biases[j]
        (x', y')[k] = sum over j of output_weights[k, j] f(n[j]) + output_biases[k]
                      + skip_weights[k] . (x, y)
        f(n) = 2 / (1 + exp(-gamma n)) - 1

    Inputs are normalised coordinates (:meth:`Geometry.normalise`); outputs are pixels of the
    distorted image. Shapes: (HN, 2), (HN,), (2, HN), (2,), (2, 2). The skip path, directly from
    the inputs to the outputs, is not the paper's; a network without it has None there.
    """
    hidden_weights: np.ndarray
    hidden_biases: np.ndarray
    output_weights: np.ndarray
    output_biases: np.ndarray
    gamma: float = 1.0
    skip_weights: np.ndarray | None = None

    @property
    def hidden_neurons(self):
        """Number of hidden neurons, HN."""
        return len(self.hidden_biases)

    def with_gamma(self, gamma):
        """The same function with another gamma: the hidden layer is rescaled to compensate.

        The scaling is exact if the ratio is a power of two, else the numbers are rounded.

        Raises
        ------
        InputError
            If gamma is not a positive number.
        """
        check_gamma(gamma)
        ratio = self.gamma / gamma
        return replace(self, hidden_weights=self.hidden_weights * ratio,
                       hidden_biases=self.hidden_biases * ratio, gamma=float(gamma))

    def __call__(self, x, y):
        """(x', y') in pixels of normalised coordinates of any common shape."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        outputs = [np.full(np.broadcast(x, y).shape, bias) for bias in self.output_biases]
        for (wx, wy), bias, *columns in zip(self.hidden_weights, self.hidden_biases,
                                            *self.output_weights):
            a = np.tanh(self.gamma * (wx * x + wy * y + bias) / 2)
            for output, weight in zip(outputs, columns):
                output += weight * a
        if self.skip_weights is not None:
            for output, (wx, wy) in zip(outputs, self.skip_weights):
                output += wx * x + wy * y
        return tuple(outputs)
