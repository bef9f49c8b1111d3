"""Error that the network at nodes adds, on whole frames of the reference lenses."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_bench.reference_lenses import ReferenceLens
from ncdc_model.evaluate import float_map
from ncdc_model.golden.network import coordinates, network, normalised_scan
from ncdc_model.golden.nodes import curvature, largest_nodes
from ncdc_model.training.choices import TrainingChoices
from ncdc_model.training.rounding import round_network
from ncdc_model.training.train import train
from ncdc_spec.fixed import Q
from ncdc_spec.float_network import FloatNetwork
from ncdc_spec.formats import Formats
from ncdc_spec.geometry import Geometry, ValidRows
from ncdc_spec.nodes import BEFORE, NODES, nodes_fit, row_nodes

__all__ = ["WIDTHS", "curvatures", "descriptor_of", "rows_of"]

WIDTHS = (640, 1280, 1920)      # of the plot's pictures

_BAND = 64                      # corrected rows at a time: bounds the memory
_CHOICES = TrainingChoices(held_out=0)
_UNROUNDED = 18                 # fraction bits of a coordinate before its final rounding


def descriptor_of(name, neurons):
    """The network of ``neurons`` trained on the dots of lens ``name``, as integers, at every pixel;
    valid where the lens has a source."""
    lens = ReferenceLens(name)
    dots, truth = lens.dots(), lens.truth()
    trained = train((dots.u, dots.v, dots.x, dots.y), dots.geometry, neurons, _CHOICES).network
    mask = np.zeros(dots.geometry.corrected[::-1], bool)
    mask[truth.v.astype(int), truth.u.astype(int)] = True
    return round_network(trained, dots.geometry, ValidRows.of_mask(mask), Formats())


def rows_of(name, descriptor, progress=lambda fraction: None):
    """A row for each distance of nodes, on every valid pixel of the lens ``name``.

    Returns
    -------
    list of dict
        ``lens``, ``hidden_neurons``, ``nodes``, ``curvature_px``, ``fixed_minus_float_max_px``.
        ``chosen``: whether ``auto`` takes that distance. ``added_max_px``, ``added_mean_px``: the
        integers' difference on an axis from the same network at every pixel, before its final
        rounding. ``bound_px``: the bound of that (``docs/explanation/nodes.md``).
    """
    d, geometry = descriptor, descriptor.geometry
    missed = curvature(float_map(d.exact_network, geometry), geometry, d.valid)
    tallies = {nodes: _Added(replace(d, nodes=nodes)) for nodes in missed}
    mask, height = d.valid.mask(geometry.corrected_width), geometry.corrected_height
    for top in range(0, height, _BAND):
        v, u = np.nonzero(mask[top:top + _BAND])
        if len(u):
            pixels = _Pixels(d, u, v + top)
            for tally in tallies.values():
                tally.add(pixels)
        progress(min(1, (top + _BAND) / height))
    best = largest_nodes(missed)
    return [{"lens": name, "hidden_neurons": d.hidden_neurons, "nodes": nodes,
             "chosen": nodes == best, "curvature_px": missed[nodes],
             **tally.row(missed[nodes])} for nodes, tally in tallies.items()]


class _Pixels:
    """Pixels of a band, and what the network says there."""

    def __init__(self, d, u, v):
        self.u, self.v = u, v
        self.integers = _unrounded(d, u, v, d.formats)
        self.exact = float_map(d.exact_network, d.geometry)(u, v)
        self.real = float_map(d.network, d.geometry)(u, v)


def _unrounded(d, u, v, formats):
    """The integer network at (u, v) before its final rounding, pixels; all but 2**-19 px exact."""
    q = Q(formats.coordinate.i_bits, _UNROUNDED)
    formats = replace(formats, coordinate=q)
    x, y = normalised_scan(u, v, d.geometry, formats)
    return tuple(q.real(raw) for raw in network(d, x, y, formats))


@dataclass
class _Added:
    """Sums over the bands of a frame for the ``descriptor`` at its nodes."""
    descriptor: object
    worst: float = 0.0
    total: float = 0.0
    count: int = 0
    from_real: float = 0.0
    pixel_noise: float = 0.0
    node_noise: float = 0.0

    def add(self, pixels):
        """Count the pixels of a band, and the nodes of its rows."""
        d = self.descriptor
        q = d.formats.coordinate
        for got, before, exact, real in zip(coordinates(d, pixels.u, pixels.v), pixels.integers,
                                            pixels.exact, pixels.real):
            added = np.abs(q.real(got) - before)
            self.worst = max(self.worst, float(added.max()))
            self.total, self.count = self.total + float(added.sum()), self.count + added.size
            self.from_real = max(self.from_real, float(np.abs(q.real(got) - real).max()))
            self.pixel_noise = max(self.pixel_noise, float(np.abs(before - exact).max()))
        if d.nodes > 1:
            columns = np.arange(row_nodes(d.geometry.corrected_width, d.nodes)) - BEFORE
            u, v = np.meshgrid(columns * d.nodes, np.unique(pixels.v))
            integers = _unrounded(d, u, v, d.network_formats)
            exact = float_map(d.exact_network, d.geometry)(u, v)
            self.node_noise = max([self.node_noise] + [float(np.abs(a - b).max())
                                                       for a, b in zip(integers, exact)])

    def row(self, missed):
        """The figures under their names, with a curvature of ``missed`` pixels."""
        return {"added_max_px": self.worst, "added_mean_px": self.total / max(1, self.count),
                "bound_px": self._bound(missed), "fixed_minus_float_max_px": self.from_real}

    def _bound(self, missed):
        d = self.descriptor
        final, unrounded = 2.0**-(d.formats.coordinate.f_bits + 1), 2.0**-(_UNROUNDED + 1)
        if d.nodes == 1:
            return final + unrounded
        rounding = 2.0**-(d.network_formats.coordinate.f_bits + 1)
        # The weights of the four nodes add up to 1.25 at most, signs left out.
        return (missed + 1.25 * (rounding + self.node_noise + unrounded)
                + self.pixel_noise + unrounded + final)


def curvatures(descriptor, width):
    """{S: curvature in px} of the same map for pictures ``width`` pixels wide.

    The network is the same function of normalised coordinates; its outputs, in pixels, are scaled.
    """
    g = descriptor.geometry
    scale = width / g.corrected_width
    sizes = [int(size * scale) // 2 * 2 for size in (*g.corrected, *g.distorted)]
    scaled, real = Geometry(*sizes), descriptor.exact_network
    scaled_network = FloatNetwork(real.hidden_weights, real.hidden_biases,
                                  real.output_weights * scale, real.output_biases * scale)
    rows = np.minimum((np.arange(sizes[1]) / scale).astype(int), g.corrected_height - 1)
    spans = (descriptor.valid.spans[rows] * scale).astype(np.int64)
    return {nodes: miss for nodes, miss in curvature(
        float_map(scaled_network, scaled), scaled, ValidRows(spans),
        [nodes for nodes in NODES if nodes_fit(nodes, sizes[0])]).items() if nodes > 1}
