"""Sources of a view's pixels, by the compiled network."""

from functools import partial

import numpy as np

from ncdc_model.compiled.coordinates import between_nodes, node_columns, tables_at
from ncdc_model.golden.view import in_spans, node_values
from ncdc_spec.view import COLUMN, NODE, PLANE, check_view_nodes

__all__ = ["view_sources"]

_ROWS = 64              # at a time: bounds the memory


def view_sources(descriptor, view):
    """(x', y', valid) of all pixels of a ``view``, shape (height, width), int32 and bool.

    The same as of :func:`ncdc_model.golden.view.view_coordinates`.

    Raises
    ------
    InputError
        If the network is evaluated at every pixel, or there is no compiled library.
    """
    check_view_nodes(descriptor.nodes)
    width, height = view.size
    u, v = np.meshgrid(node_columns(width, descriptor.nodes), np.arange(height))
    *positions, x, y, fits = node_values(descriptor, view, u, v, partial(tables_at, descriptor))
    formats = descriptor.network_formats.coordinate, descriptor.formats.coordinate
    x, y = (between_nodes(table, descriptor.nodes, width, *formats)
            for table in (x, y))
    column, row = (between_nodes((p >> PLANE.f_bits - NODE.f_bits).astype(np.int32),
                                 descriptor.nodes, width, NODE, COLUMN) for p in positions)
    segments = fits[:, :-3] & fits[:, 1:-2] & fits[:, 2:-1] & fits[:, 3:]
    valid = np.repeat(segments, descriptor.nodes, axis=1)[:, :width]
    for top in range(0, height, _ROWS):
        rows = slice(top, top + _ROWS)
        valid[rows] &= in_spans(descriptor.valid, column[rows], row[rows])
    return x, y, np.ascontiguousarray(valid)
