"""Descriptors that state the camera of their corrected picture, and shaking cameras."""

from dataclasses import replace

import numpy as np
from scipy.spatial.transform import Rotation

from cameras import barrel_descriptor

__all__ = ["SIZE", "seen_lens", "shaking"]

SIZE = 96, 64


def seen_lens(size=SIZE, focal=60.0, centre=(46.5, 33.0), **geometry):
    """A small descriptor at nodes, with a focal length and a centre a little off the middle."""
    return replace(barrel_descriptor(size, size, hidden_neurons=16, strength=.4, **geometry),
                   nodes=8, provenance={"frame": [focal, *centre]})


def shaking(times, degrees, seed=1):
    """Smooth rotation vectors (n, 3) in radians at ``times``, and their SciPy rotations.

    ``degrees``: the largest angle about each axis.
    """
    rng = np.random.default_rng(seed)
    rate, phase = rng.uniform(2, 15, (3, 1)), rng.uniform(0, 6, (3, 1))
    vectors = np.radians(degrees) * np.sin(2 * np.pi * rate * np.asarray(times) + phase).T
    return vectors, Rotation.from_rotvec(vectors)
