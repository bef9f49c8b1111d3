"""Windows of a frame as no lens makes them, and as one does."""

import numpy as np

from ncdc_model.planner.lookups import Windows

__all__ = ["random_windows", "walking_windows"]


def random_windows(seed, size=(64, 48), reach=200, blank=.2):
    """Windows all over a frame of ``reach`` pixels: dense evictions."""
    rng = np.random.default_rng(seed)
    width, height = size
    x0, y0 = rng.integers(0, reach, (2, height, width)).astype(np.int32)
    used = rng.random((height, width)) >= blank
    return Windows(np.where(used, x0, 0), np.where(used, y0, 0), used)


def walking_windows(seed, size=(64, 48), reach=300):
    """Windows that wander by small steps, as those of a lens do, and jump now and then."""
    rng = np.random.default_rng(seed)
    steps = rng.integers(-1, 3, (2, size[0] * size[1]))
    jumps = rng.random(steps.shape) < .01
    position = np.cumsum(steps + jumps * rng.integers(-60, 60, steps.shape), axis=1) % reach
    x0, y0 = position.astype(np.int32).reshape(2, size[1], size[0])
    return Windows(x0, y0, rng.random(x0.shape) >= .1)
