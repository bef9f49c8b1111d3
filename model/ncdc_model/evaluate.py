"""Errors of a map in pixels: float and integer network, on points and on whole frames."""

import numpy as np

from ncdc_model.correction import frame_coordinates
from ncdc_model.golden.network import network, round_between
from ncdc_model.golden.nodes import CURVATURE_LIMIT, curvature, sums_between
from ncdc_spec.errors import InputError

__all__ = ["check_curvature", "evaluate_frame", "evaluate_points", "fixed_map", "float_map",
           "map_error"]

_ROWS = 16             # corrected rows at a time: they stay in the cache


def map_error(map_a, map_b, mask=None):
    """Difference of two maps: dict of ``mse``, ``mean`` and ``max``.

    ``map_a`` and ``map_b`` are pairs (x, y) of arrays in pixels of the distorted image, ``mask``
    (optional, bool) selects. ``mse`` is the mean of dx^2 + dy^2, ``mean`` and ``max`` are of the
    Euclidean distance. If nothing is selected, the three are ``nan``.
    """
    square = ((np.asarray(map_a[0], np.float64) - map_b[0])**2
              + (np.asarray(map_a[1], np.float64) - map_b[1])**2)
    tally = _Tally()
    tally.add(square if mask is None else square[mask])
    return tally.errors()


def float_map(network, geometry):
    """The map (u, v) -> (x, y) in pixels of a :class:`FloatNetwork`."""
    return lambda u, v: network(*geometry.normalise(u, v))


def fixed_map(descriptor):
    """The map (u, v) -> (x, y) in pixels of the integer network, at real coordinates.

    The hardware computes whole pixels only, at which this equals ``network.coordinates``. Between
    them the normalised coordinate is rounded to the format of the neurons' input. With nodes, which
    are at whole pixels, only that of the row is rounded. It saturates outside the frame.
    """
    geometry, q = descriptor.geometry, descriptor.network_formats.input

    def at(u, v):
        x, y = (np.clip(q.quantise(n), q.lo, q.hi) for n in geometry.normalise(u, v))
        return network(descriptor, x, y)

    def back_map(u, v):
        raws = at(u, v) if descriptor.nodes == 1 else _between_nodes(descriptor, at, u, v)
        return tuple(descriptor.formats.coordinate.real(raw) for raw in raws)
    return back_map


def _between_nodes(descriptor, at, u, v):
    """Raw coordinates of real (u, v) from the raw nodes ``at(u, v)`` of each pixel's row.

    The sum between nodes is below 2**53 and so exact at whole pixels.
    """
    nodes = descriptor.nodes
    u = np.asarray(u, np.float64)
    k = np.floor_divide(u, nodes)
    corners = zip(*(at((k + step) * nodes, v) for step in (-1, 0, 1, 2)))
    return (round_between(np.floor(sums_between(*corner, u - k * nodes, nodes)).astype(np.int64),
                          descriptor) for corner in corners)


def check_curvature(descriptor, choices=None):
    """Error of interpolation between nodes from the descriptor's own network: {S: pixels}.

    The network has real numbers that are exactly the integers, see
    :func:`ncdc_model.golden.nodes.curvature`. ``choices``: distances S; the descriptor's by
    default.

    Raises
    ------
    InputError
        If there is one choice only and its error is larger than the limit.
    """
    geometry = descriptor.geometry
    choices = choices or (descriptor.nodes,)
    found = curvature(float_map(descriptor.exact_network, geometry), geometry, descriptor.valid,
                      choices)
    if len(choices) == 1 and found[choices[0]] > CURVATURE_LIMIT:
        raise InputError(f"nodes {choices[0]} pixels apart miss this map by "
                         f"{found[choices[0]]:.2g} px, the limit is {CURVATURE_LIMIT:g}")
    return found


def evaluate_points(descriptor, u, v, x, y):
    """Errors at calibrated points (u, v) -> (x, y), those inside the corrected frame.

    Returns a dict of ``points`` and, as in :func:`map_error`, ``map_error_float_px`` and
    ``map_error_fixed_px``.
    """
    width, height = descriptor.geometry.corrected
    u, v, x, y = (np.asarray(values, np.float64) for values in (u, v, x, y))
    on = (u >= 0) & (u <= width - 1) & (v >= 0) & (v <= height - 1)
    u, v, truth = u[on], v[on], (x[on], y[on])
    return {"points": int(on.sum()),
            "map_error_float_px": map_error(
                float_map(descriptor.network, descriptor.geometry)(u, v), truth),
            "map_error_fixed_px": map_error(fixed_map(descriptor)(u, v), truth)}


def evaluate_frame(descriptor, back_map=None, maps=None, progress=lambda fraction: None):
    """Errors at every valid pixel of the corrected frame.

    Parameters
    ----------
    descriptor : Descriptor
    back_map : callable, optional
        The true map (u, v) -> (x, y); not-a-number where there is no source.
    maps : dict, optional
        Filled with ``float`` and ``fixed``, the Euclidean distances to the truth in pixels,
        float32 of shape (height, width), ``nan`` where a pixel is not valid.
    progress : callable, optional
        Called with the fraction of the rows done.

    Returns
    -------
    dict
        ``hidden_neurons``; ``nodes``, their distance; ``valid_pixels``;
        ``fixed_minus_float_max_px``, the largest difference on an axis
        between the integer and the float network; with ``back_map`` also
        ``map_error_float_px`` and ``map_error_fixed_px`` as in :func:`map_error`.
    """
    geometry, coordinate = descriptor.geometry, descriptor.formats.coordinate
    width, height = geometry.corrected
    valid = descriptor.valid.mask(width)
    real, fixed = float_map(descriptor.network, geometry), frame_coordinates(descriptor)
    tallies, worst = {"float": _Tally(), "fixed": _Tally()}, 0.0
    for name in tallies if maps is not None else ():
        maps[name] = np.full((height, width), np.nan, np.float32)
    for top in range(0, height, _ROWS):
        progress(min(top + _ROWS, height) / height)
        v, u = np.nonzero(valid[top:top + _ROWS])
        v += top
        if not len(u):
            continue
        both = {"float": real(u, v),
                "fixed": tuple(coordinate.real(raw[v, u]) for raw in fixed)}
        worst = max(worst, *(float(np.abs(a - b).max()) for a, b in zip(*both.values())))
        if back_map is None:
            continue
        x, y = back_map(u.astype(np.float64), v.astype(np.float64))
        known = np.isfinite(x) & np.isfinite(y)
        for name, (a, b) in both.items():
            square = (a - x)**2 + (b - y)**2
            tallies[name].add(square[known])
            if maps is not None:
                maps[name][v, u] = np.sqrt(square)
    report = {"hidden_neurons": descriptor.hidden_neurons, "nodes": descriptor.nodes,
              "valid_pixels": int(valid.sum()),
              "fixed_minus_float_max_px": worst}
    if back_map is not None:
        report["map_error_float_px"] = tallies["float"].errors()
        report["map_error_fixed_px"] = tallies["fixed"].errors()
    return report


class _Tally:
    """Accumulates squared distances part by part."""

    def __init__(self):
        self.count, self.square, self.distance, self.worst = 0, 0.0, 0.0, 0.0

    def add(self, square):
        if square.size:
            self.count += square.size
            self.square += float(square.sum())
            self.distance += float(np.sqrt(square).sum())
            self.worst = max(self.worst, float(square.max()))

    def errors(self):
        if not self.count:
            return dict.fromkeys(("mse", "mean", "max"), float("nan"))
        return {"mse": self.square / self.count, "mean": self.distance / self.count,
                "max": self.worst**.5}
