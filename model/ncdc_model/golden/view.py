"""Reference model of a view in integers: from the pixels of its picture to the raw frame.

``docs/explanation/view.md`` derives the errors.
"""

from functools import partial

import numpy as np

from ncdc_model.golden.network import network, round_between
from ncdc_model.golden.nodes import between, node_grid, round_sums
from ncdc_model.golden.view_rows import added, next_rows
from ncdc_spec.geometry import SCAN
from ncdc_spec.reciprocal import (
    CURVE_BITS,
    INDEX_BITS,
    RECIPROCAL_BITS,
    REST_BITS,
    SLOPE_BITS,
    SQUARE_BITS,
    coefficients,
)
from ncdc_spec.view import (
    COLUMN,
    DEPTH_SHIFTS,
    FORMATS,
    NODE,
    NUMERATOR,
    PLANE,
    check_view_nodes,
)
from ncdc_spec.view_rows import SETTLING

__all__ = ["divided", "homogeneous", "in_spans", "node_positions", "node_values", "normalised",
           "positions_of", "reciprocal", "view_coordinates"]


def homogeneous(view, u, v):
    """X, Y and Z of the pixels (u, v) of a view, exact, in the fraction bits of their steps."""
    u, v = np.asarray(u, np.int64), np.asarray(v, np.int64)
    sums = []
    for (step_u, step_v, origin), (step, _, q) in zip(np.reshape(view.matrix, (3, 3)).tolist(),
                                                      FORMATS):
        sums.append((origin << step.f_bits - q.f_bits) + u * step_u + v * step_v)
    return sums


def reciprocal(z):
    """(1 / m, n, whether the depth is in its range) of depths ``z`` = m / 2**n, 1 <= m < 2.

    The reciprocal has :data:`RECIPROCAL_BITS` fraction bits; n is at most ``DEPTH_SHIFTS``. Outside
    of the range both are those of the nearest depth inside.
    """
    top = FORMATS[2][0].f_bits                      # bit of a depth of 1
    lowest, beyond = 1 << top - DEPTH_SHIFTS, 2 << top
    inside = (z >= lowest) & (z < beyond)
    z = np.clip(z, lowest, beyond - 1)
    n = np.zeros(z.shape, np.int64)
    for shifts in range(1, DEPTH_SHIFTS + 1):
        n += z < 2 << top - shifts
    fraction = (z << n) - (1 << top) >> top - INDEX_BITS - REST_BITS
    segment, t = fraction >> REST_BITS, fraction & (1 << REST_BITS) - 1
    c0, c1, c2 = np.array(coefficients())[segment].transpose(-1, *range(z.ndim))
    fine = CURVE_BITS + INDEX_BITS + SQUARE_BITS    # fraction bits of c2 t
    slope = c1 - (c2 * (t >> REST_BITS - SQUARE_BITS) >> fine - SLOPE_BITS)
    fine = SLOPE_BITS + INDEX_BITS + REST_BITS      # of the slope times t
    shift = fine - RECIPROCAL_BITS
    return c0 - (slope * t + (1 << shift - 1) >> shift), n, inside


def divided(numerator, one_over, n):
    """(position in :data:`PLANE`, whether it fits) of X or Y and :func:`reciprocal` of the depth.

    What does not fit is limited to the range.
    """
    shifted, fits = _limited((numerator << n) >> FORMATS[0][0].f_bits - NUMERATOR.f_bits, NUMERATOR)
    shift = NUMERATOR.f_bits + RECIPROCAL_BITS - PLANE.f_bits
    position, holds = _limited(shifted * one_over + (1 << shift - 1) >> shift, PLANE)
    return position, fits & holds


def normalised(position, origin, step, q):
    """(normalised coordinate in ``q``, whether it fits) of a position in :data:`PLANE`.

    ``origin`` and ``step`` are those of the trained picture's scan.
    """
    shift = PLANE.f_bits + SCAN.f_bits - q.f_bits
    total = (origin << PLANE.f_bits) + position * step
    return _limited(total + (1 << shift - 1) >> shift, q)


def _limited(raw, q):
    return np.clip(raw, q.lo, q.hi), q.inside(raw)


def node_positions(descriptor, view, u, v):
    """What a view computes of its nodes (u, v): positions, inputs of the network, whether all fit.

    Returns
    -------
    (ndarray, ndarray)
        Positions x, y in the trained picture, raw in :data:`PLANE`.
    (ndarray, ndarray)
        Normalised x, y, raw in the network's input format.
    ndarray of bool
        Whether the depth is in its range, and neither positions nor inputs overflow.
    """
    return positions_of(descriptor, homogeneous(view, u, v))


def positions_of(descriptor, sums):
    """As :func:`node_positions`, of the ``sums`` X, Y and Z of nodes."""
    *numerators, z = sums
    one_over, n, fits = reciprocal(z)
    scan = descriptor.geometry.scan()
    positions, inputs = [], []
    for axis, numerator in enumerate(numerators):
        position, divides = divided(numerator, one_over, n)
        value, holds = normalised(position, *scan[2 * axis:2 * axis + 2],
                                  descriptor.network_formats.input)
        positions.append(position)
        inputs.append(value)
        fits = fits & divides & holds
    return tuple(positions), tuple(inputs), fits


def node_values(descriptor, view, columns, lines, network):
    """Positions x and y, coordinates x' and y', and whether it fits, of each node of a ``view``.

    With a table of matrices all rows from the first one on are computed, one after the other.

    Parameters
    ----------
    descriptor : Descriptor
    view : View
    columns, lines : ndarray of int, shape (rows, nodes)
        Pixel at each node.
    network : callable
        Raw coordinates (x', y') of raw inputs (x, y) of one shape.

    Returns
    -------
    tuple of 5 ndarray, shape (rows, nodes)
    """
    if view.rows is None:
        positions, inputs, fits = node_positions(descriptor, view, columns, lines)
        return *positions, *network(*inputs), fits
    u, found = columns[0], []
    row = np.zeros(len(u), np.int64)
    for line in range(-SETTLING, int(lines[-1, 0]) + 1):
        v = np.full(len(u), max(line, 0))
        sums = [base + more for base, more in zip(homogeneous(view, u, v),
                                                  added(view.rows, u, v, row))]
        positions, inputs, fits = positions_of(descriptor, sums)
        x, y = network(*inputs)
        row = next_rows(y, fits, descriptor.network_formats.coordinate)
        found.append((*positions, x, y, fits))
    return tuple(np.stack(one)[SETTLING + lines[:, 0]] for one in zip(*found))


def view_coordinates(descriptor, view, u, v):
    """(x', y', valid) of the pixels (u, v) of a ``view``, integer arrays.

    x' and y' are raw in ``formats.coordinate``, with a meaning only where ``valid``. A pixel is
    valid if all four nodes around it fit (:func:`node_positions`), and the pixel of the trained
    picture that is nearest to its position is in a valid span. The positions between nodes are
    interpolated like the coordinates.

    Raises
    ------
    InputError
        If the network is evaluated at every pixel.
    """
    d, nodes = descriptor, descriptor.nodes
    check_view_nodes(nodes)
    u, v = np.broadcast_arrays(np.asarray(u, np.int64), np.asarray(v, np.int64))
    if not u.size:
        return (*np.zeros((2, *u.shape), np.int64), np.zeros(u.shape, bool))
    columns, lines, nodes_of = node_grid(u, v, nodes)
    *positions, x, y, fits = node_values(d, view, columns, lines, partial(network, d))
    x, y = (round_between(between(nodes_of(table), u, nodes), d) for table in (x, y))
    column, row = (round_sums(between(nodes_of(p >> PLANE.f_bits - NODE.f_bits), u, nodes), nodes,
                              NODE, COLUMN) for p in positions)
    around = [nodes_of(fits)(u // nodes + step) for step in (-1, 0, 1, 2)]
    return x, y, np.logical_and.reduce(around) & in_spans(d.valid, column, row)


def in_spans(valid, column, row):
    """Whether the pixels of the trained picture at (column, row) lie in a valid span."""
    spans = valid.spans
    start0, stop0, start1, stop1 = spans[np.clip(row, 0, len(spans) - 1)].transpose(
        -1, *range(row.ndim))
    return (row >= 0) & (row < len(spans)) & ((column >= start0) & (column < stop0)
                                              | (column >= start1) & (column < stop1))
