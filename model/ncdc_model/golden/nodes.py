"""The network at nodes (grid points): coordinates between them are interpolated.

The interpolation is a line and the mean of two second differences. Between the nodes P1 and P2 of
a row, S pixels apart, with their neighbours P0 and P3::

    x(j) = P1 + j (P2 - P1) / S - j (S - j) / (4 S^2) ((P3 - P2) - (P1 - P0)),    0 <= j < S

Node k is at the corrected column k S in every strip, so that the coordinates do not depend
on the order of the scan. ``docs/explanation/nodes.md`` derives the error.
"""

import numpy as np

from ncdc_spec.fixed import requantise
from ncdc_spec.nodes import NODES, nodes_fit

__all__ = ["CURVATURE_LIMIT", "between", "curvature", "interpolated_map", "largest_nodes",
           "node_grid", "round_sums", "sums_between"]

CURVATURE_LIMIT = .001      # px, largest error of the interpolation

_EVERY = 4                  # rows: of those between, the largest error hardly differs
_ROWS = 64                  # rows at a time: bounds the memory


def sums_between(p0, p1, p2, p3, j, nodes):
    """4 S^2 x(j), exact where the nodes and j are integers."""
    bend = (p3 - p2) - (p1 - p0)
    return 4 * nodes * (nodes * p1 + j * (p2 - p1)) - j * (nodes - j) * bend


def between(nodes_of, u, nodes):
    """4 S^2 x at columns ``u`` (real or whole); ``nodes_of(k)``: node k of each pixel's row."""
    k = np.floor_divide(u, nodes)
    return sums_between(*(nodes_of(k + step) for step in (-1, 0, 1, 2)), u - k * nodes, nodes)


def round_sums(sums, nodes, fine, coarse):
    """Values in ``coarse`` of :func:`sums_between` of nodes in ``fine``."""
    return requantise(sums, 2 + 2 * (nodes.bit_length() - 1) + fine.f_bits - coarse.f_bits, coarse)


def node_grid(u, v, nodes):
    """The nodes that pixels (u, v) of any rows need, each row's from the first to the last.

    Returns
    -------
    columns, lines : ndarray of int
        Pixel at each node, shape (rows, nodes of a row).
    nodes_of : callable
        Of a table of values at the nodes, the function that :func:`between` needs.
    """
    rows, row = np.unique(v, return_inverse=True)
    first, last = u.min() // nodes - 1, u.max() // nodes + 2
    columns, lines = np.meshgrid(np.arange(first, last + 1) * nodes, rows)
    row = row.reshape(v.shape)
    return columns, lines, lambda table: lambda k: table[row, k - first]


def interpolated_map(back_map, nodes):
    """The map (u, v) -> (x, y) between nodes of the map ``back_map``, without rounding."""
    if nodes == 1:
        return back_map

    def interpolate(u, v):
        u, v = np.broadcast_arrays(np.asarray(u, np.float64), np.asarray(v, np.float64))
        rows, row = np.unique(v, return_inverse=True)
        row = row.reshape(v.shape)
        first, last = u.min() // nodes - 1, u.max() // nodes + 2
        grid = np.arange(first, last + 1) * nodes
        if rows.size * grid.size > 4 * u.size:      # scattered points: no grid of rows
            values = [np.stack(back_map((u // nodes + step) * nodes, v)) for step in
                      (-1, 0, 1, 2)]
            k = u // nodes
            return tuple(sums_between(*p, u - k * nodes, nodes) / (4 * nodes**2)
                         for p in zip(*values))
        k = np.floor_divide(u, nodes)
        at = row * grid.size + (k - first).astype(np.int64)
        tables = (table.ravel() for table in back_map(*np.meshgrid(grid, rows)))
        return tuple(sums_between(*(table[at + step] for step in (-1, 0, 1, 2)), u - k * nodes,
                                  nodes) / (4 * nodes**2) for table in tables)
    return interpolate


def curvature(back_map, geometry, valid, choices=NODES):
    """Error of :func:`interpolated_map` from ``back_map``: {S: pixels}.

    It is the largest difference on an axis over the valid pixels of every fourth row, for each S
    of ``choices`` that fits the picture's width.

    Parameters
    ----------
    back_map : callable
        A smooth map, also outside the picture: the float network's.
    geometry : Geometry
    valid : ValidRows
    choices : sequence of int
    """
    width, height = geometry.corrected
    worst = {nodes: 0.0 for nodes in choices if nodes_fit(nodes, width)}
    mask = valid.mask(width)
    for top in range(0, height, _ROWS):
        v, u = np.nonzero(mask[top:top + _ROWS:_EVERY])
        if not len(u):
            continue
        u, v = u.astype(np.float64), _EVERY * v + float(top)
        exact = back_map(u, v)
        for nodes in worst:
            if nodes > 1:
                near = interpolated_map(back_map, nodes)(u, v)
                worst[nodes] = max(worst[nodes], *(float(np.abs(a - b).max())
                                                   for a, b in zip(near, exact)))
    return worst


def largest_nodes(found):
    """The largest S of :func:`curvature` ``found`` within the limit; the smallest if none is."""
    return max((nodes for nodes, miss in found.items() if miss <= CURVATURE_LIMIT),
               default=min(found))
