"""Medians of what is known."""

import numpy as np

__all__ = ["known_median"]


def known_median(values):
    """Medians (m, ...) of the finite numbers of ``values`` (m, n, ...) over the second axis;
    not-a-number where there is none.

    NumPy's ``nanmedian`` takes ten times as long over short axes.
    """
    ordered = np.sort(values, axis=1)       # not-a-numbers come last
    count = np.isfinite(ordered).sum(axis=1, keepdims=True)
    lower, upper = (np.take_along_axis(ordered, middle, axis=1) for middle in (
        np.maximum(count - 1, 0) // 2, np.minimum(count // 2, ordered.shape[1] - 1)))
    return ((lower + upper) / 2).squeeze(1)
