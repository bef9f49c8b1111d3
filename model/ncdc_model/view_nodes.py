"""Error that interpolation between nodes adds to views, by the distance of the nodes."""

from dataclasses import replace
from functools import cache

import numpy as np

from ncdc_model.evaluate import float_map
from ncdc_model.golden.nodes import interpolated_map
from ncdc_model.golden.view import in_spans, node_positions
from ncdc_model.view_map import plane_points
from ncdc_spec.nodes import AFTER, BEFORE, NODES, nodes_fit

__all__ = ["NodeErrors", "errors_report", "node_errors", "worst_node_errors"]

_ROWS = 16              # every so many rows of a view: between them the error hardly differs


class NodeErrors:
    """Errors of views of one descriptor.

    Parameters
    ----------
    descriptor : Descriptor
        Its distance of nodes does not count.
    every : int
        Rows of a view from one that is evaluated to the next.
    """
    def __init__(self, descriptor, every=_ROWS):
        # The formats are the same for all distances.
        self._descriptor = replace(descriptor, nodes=NODES[1]) if descriptor.nodes == 1 else (
            descriptor)
        self._every = every
        self._map = float_map(descriptor.exact_network, descriptor.geometry)

    def of(self, view, choices):
        """Largest error on an axis, in raw pixels, over the pixels of a ``view`` that have a
        source: {S: error} for the distances S of ``choices``.

        Map and matrix are in real numbers. It is the error of the interpolation alone.
        """
        width, height = view.size
        v, u = np.mgrid[0:height:self._every, 0:width].astype(np.float64)
        with np.errstate(all="ignore"):
            column, row = plane_points(view.real, u, v)
            inside = in_spans(self._descriptor.valid, _whole(column), _whole(row))
            exact = self._map(column, row)
            return {nodes: self._error(view, nodes, u, v, exact, inside) for nodes in choices}

    def _error(self, view, nodes, u, v, exact, inside):
        near = interpolated_map(lambda u, v: self._map(*plane_points(view.real, u, v)), nodes)(u, v)
        used = inside & self._fit(view, nodes, u, v)
        return max(float(np.abs(a - b)[used].max(initial=0)) for a, b in zip(near, exact))

    def _fit(self, view, nodes, u, v):
        """Whether the four nodes around each pixel (u, v) of whole rows fit their formats."""
        segments = -(-u.shape[1] // nodes)
        columns = nodes * np.arange(-BEFORE, segments + AFTER)
        *_, fits = node_positions(self._descriptor, view,
                                  *np.meshgrid(columns, v[:, 0].astype(np.int64)))
        four = np.logical_and.reduce([fits[:, k:k + segments] for k in range(BEFORE + AFTER + 1)])
        return np.repeat(four, nodes, axis=1)[:, :u.shape[1]]


def _whole(position):
    return np.rint(np.nan_to_num(position, nan=-1)).clip(-1, 1 << 15).astype(np.int64)


def node_errors(descriptor, view, choices=NODES):
    """:meth:`NodeErrors.of` one view."""
    return NodeErrors(descriptor).of(view, choices)


def worst_node_errors(descriptor, views, nodes=None, progress=lambda fraction: None):
    """Largest error of each distance of nodes in the views that a scan of the range, and a climb
    from the worst of them, visit.

    Parameters
    ----------
    descriptor : Descriptor
    views : ViewRange
    nodes : int, optional
        Distance by whose error the climb goes; the largest one by default.
    progress : callable
        Called with the fraction done.

    Returns
    -------
    dict of int to (float, Angles)
        By distance: the error in raw pixels, and the view that has it.
    """
    errors, found = NodeErrors(descriptor), {}
    choices = [one for one in NODES if one > 1
               and nodes_fit(one, descriptor.geometry.corrected_width)]

    @cache
    def score(angles):
        missed = errors.of(views.view(angles), choices)
        for one, error in missed.items():
            if one not in found or error > found[one][0]:
                found[one] = error, angles
        return missed[nodes or choices[-1]]

    scanned = views.scan()
    for k, angles in enumerate(scanned):
        score(angles)
        progress(k / len(scanned))
    views.climb(score, max(scanned, key=score))
    progress(1)
    return found


def errors_report(views, errors):
    """The range ``views`` and the ``errors`` of :func:`worst_node_errors` as in every report."""
    return {"views": views.report, "views_nodes_px": {
        str(nodes): {"max": error, "view": vars(at)} for nodes, (error, at) in errors.items()}}
