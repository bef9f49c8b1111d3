"""Reference model in integers of a view with a table of matrices down the raw frame.

A node's matrix is that of a raw row, which is known only after the node. The raw row of the node
above is taken, and one more. ``docs/explanation/view.md`` derives the error.
"""

import numpy as np

from ncdc_spec.view_rows import (
    NUMBER_BITS,
    ROW_BITS,
    ROW_SHIFT,
    SHARE_BITS,
    STEP_SHIFT,
    STEPS,
)

__all__ = ["added", "next_rows"]

_FINEST = STEPS[0].bit_length() - 1     # log2 of the smallest step


def added(table, u, v, row):
    """What a :class:`~ncdc_spec.view_rows.RowTable` adds to X, Y and Z of the nodes (u, v).

    ``row``: raw row that selects the matrix of each node. The result has the fraction bits of
    the steps of a view.
    """
    at = np.asarray(row, np.int64) << SHARE_BITS >> STEPS.index(table.step) + _FINEST
    last = len(table.matrices) - 1
    beyond = at >> SHARE_BITS >= last
    k = np.where(beyond, last, at >> SHARE_BITS)
    share = np.where(beyond, 0, at & (1 << SHARE_BITS) - 1)
    matrices = np.reshape(table.matrices, (-1, 3, 3))
    here, below = (_sums(matrices[one], u, v) for one in (k, np.minimum(k + 1, last)))
    half = 1 << NUMBER_BITS - 1
    # A difference of so few bits wraps, which only nonsense does.
    change = (below - here + half & (1 << NUMBER_BITS) - 1) - half
    return np.moveaxis(here + (change * share[..., None] >> SHARE_BITS) << ROW_SHIFT, -1, 0)


def _sums(matrices, u, v):
    """X, Y and Z of nodes by matrices (..., 3, 3), in the fraction bits of their origins."""
    steps = matrices[..., 0] * u[..., None] + matrices[..., 1] * v[..., None]
    return (steps >> STEP_SHIFT) + matrices[..., 2]


def next_rows(y, fits, coordinate):
    """Raw rows that select the matrices of the nodes below those with the raw coordinates ``y``.

    ``coordinate``: format of ``y``. Below a node that does not fit it is row 0.
    """
    row = y + (3 << coordinate.f_bits - 1) >> coordinate.f_bits
    return np.where(fits, np.clip(row, 0, (1 << ROW_BITS) - 1), 0)
