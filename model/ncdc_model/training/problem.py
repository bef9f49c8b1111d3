"""The training problem: calibrated points, their split, and errors of a network on them."""

from dataclasses import dataclass

import numpy as np

from ncdc_spec.errors import InputError
from ncdc_spec.geometry import Geometry

__all__ = ["MIN_POINTS_PER_NEURON", "Problem", "errors_of", "split", "spread"]

MIN_POINTS_PER_NEURON = 3      # 5 parameters a neuron, two equations a point


@dataclass(frozen=True)
class Problem:
    """Pairs of a corrected pixel and its source in the distorted image.

    Parameters
    ----------
    u, v : ndarray, shape (N,)
        Corrected pixel coordinates; may be slightly outside the frame.
    x, y : ndarray, shape (N,)
        Distorted pixel coordinates.
    geometry : Geometry

    Raises
    ------
    InputError
        If the arrays differ in length or hold values that are not finite.
    """
    u: np.ndarray
    v: np.ndarray
    x: np.ndarray
    y: np.ndarray
    geometry: Geometry

    def __post_init__(self):
        for name in ("u", "v", "x", "y"):
            values = np.asarray(getattr(self, name), np.float64).ravel()
            object.__setattr__(self, name, values)
            if len(values) != len(self.u):
                raise InputError(f"the training pairs have {len(self.u)} values u "
                                 f"but {len(values)} values {name}")
            if not np.isfinite(values).all():
                bad = int(np.flatnonzero(~np.isfinite(values))[0])
                raise InputError(f"training pair {bad} has {name} = {values[bad]}, "
                                 f"a finite number is needed")

    def __len__(self):
        return len(self.u)

    @property
    def inputs(self):
        """Normalised (x, y) of the corrected pixels, shape (2, N)."""
        return np.stack(self.geometry.normalise(self.u, self.v))

    @property
    def targets(self):
        """Distorted pixels, shape (2, N)."""
        return np.stack([self.x, self.y])

    def take(self, which):
        """The sub-problem of the pairs ``which`` (indices or boolean mask)."""
        return Problem(self.u[which], self.v[which], self.x[which], self.y[which], self.geometry)

    def check(self, neurons):
        """Raise :class:`InputError` unless the pairs can determine ``neurons`` hidden neurons."""
        minimum = MIN_POINTS_PER_NEURON * neurons
        if len(self) < minimum:
            raise InputError(f"{len(self)} training points are too few for {neurons} "
                             f"hidden neurons, {minimum} is the limit")


def split(count, every):
    """Boolean mask, shape (``count``,), of the points held out: about one in ``every``.

    A hash of its index decides for each point, so that no rows and columns of a grid are favoured;
    ``every`` = 0 holds out none.
    """
    if every == 0:
        return np.zeros(count, bool)
    if every < 2:
        raise InputError(f"one held-out point in {every} leaves none to train on, 2 is the limit")
    return _hashed(count) % every == 0


def spread(count, limit):
    """Indices, ascending, of at most ``limit`` of ``count`` points, spread by hashed index."""
    return np.sort(np.argsort(_hashed(count), kind="stable")[:limit])


def _hashed(count):
    # Fibonacci hashing alone is a lattice; the shift mixes its high bits into the low ones.
    key = np.arange(1, count + 1, dtype=np.uint64) * np.uint64(0x9E3779B97F4A7C15)
    key = (key ^ (key >> np.uint64(29))) * np.uint64(0xBF58476D1CE4E5B9)
    return key ^ (key >> np.uint64(32))


def errors_of(network, problem):
    """Errors of ``network`` on ``problem``: dict of mse, mean, max and points.

    Units are pixels of the distorted image. ``mse`` is the mean of dx^2 + dy^2; ``mean`` and
    ``max`` are of the Euclidean distance. Without points the three are ``nan``.
    """
    if not len(problem):
        return {"mse": float("nan"), "mean": float("nan"), "max": float("nan"), "points": 0}
    x, y = network(*problem.inputs)
    square = (x - problem.x)**2 + (y - problem.y)**2
    distance = np.sqrt(square)
    return {"mse": float(square.mean()), "mean": float(distance.mean()),
            "max": float(distance.max()), "points": len(problem)}
