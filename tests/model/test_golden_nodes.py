"""The network at nodes: sums in exact fractions, real maps whose interpolation is known."""

from fractions import Fraction
from math import floor

import numpy as np
import pytest

from ncdc_model.golden.nodes import (
    CURVATURE_LIMIT,
    between,
    curvature,
    interpolated_map,
    largest_nodes,
    node_grid,
    round_sums,
    sums_between,
)
from ncdc_spec.fixed import Q
from ncdc_spec.geometry import Geometry, ValidRows

distances = pytest.mark.parametrize("nodes", [8, 16, 32])


def exact_between(p, j, nodes):
    """The equation of docs/explanation/nodes.md, of four nodes ``p``."""
    p0, p1, p2, p3 = map(Fraction, p)
    return (p1 + j * (p2 - p1) / nodes
            - Fraction(j * (nodes - j), 4 * nodes**2) * ((p3 - p2) - (p1 - p0)))


@distances
def test_sums_are_the_equation(nodes):
    rng = np.random.default_rng(nodes)
    values = rng.integers(-1 << 20, 1 << 20, (4, nodes))
    got = sums_between(*values, np.arange(nodes), nodes)
    for j in range(nodes):
        assert got[j] == 4 * nodes**2 * exact_between(values[:, j].tolist(), j, nodes)


@distances
def test_pixels_find_their_nodes_and_are_rounded_once(nodes):
    """Rows neither sorted nor all different, columns before and after the frame's."""
    rng = np.random.default_rng(nodes)
    u, v = rng.integers(-2 * nodes, 5 * nodes, (3, 5)), rng.integers(0, 4, (3, 5))
    u[1, 2], u[2, 3] = 3 * nodes - 1, -2 * nodes
    columns, lines, nodes_of = node_grid(u, v, nodes)
    assert columns.shape == lines.shape == (len(set(v.ravel())), columns.shape[1])
    assert columns[0].tolist() == list(range(
        (u.min() // nodes - 1) * nodes, (u.max() // nodes + 3) * nodes, nodes))
    assert lines[:, 0].tolist() == sorted(set(v.ravel()))
    # A value of 30 bits that depends on column and line in no simple way.
    table = (columns * 7919 + lines * 104_729) ** 2 % (1 << 30)
    fine, coarse = Q(20, 14), Q(24, 6)
    sums = between(nodes_of(table), u, nodes)
    rounded = round_sums(sums, nodes, fine, coarse)
    for at in np.ndindex(u.shape):
        k, j = divmod(int(u[at]), nodes)
        near = [((k + step) * nodes * 7919 + int(v[at]) * 104_729) ** 2 % (1 << 30)
                for step in (-1, 0, 1, 2)]
        exact = exact_between(near, j, nodes)
        assert sums[at] == 4 * nodes**2 * exact
        assert rounded[at] == min(floor(exact / 256 + Fraction(1, 2)), (1 << 29) - 1)


@distances
def test_real_columns_lie_between_nodes(nodes):
    u = np.array([0.25, nodes - .5, 3.75 * nodes, -.25])
    got = between(lambda k: 3.0 * (k * nodes)**2, u, nodes) / (4 * nodes**2)
    np.testing.assert_allclose(got, 3 * u**2, rtol=1e-12)      # a parabola is met exactly


def cubic(u, v):
    """The interpolation misses x by c j (j - S) (j - S / 2), and a quadratic y by nothing."""
    return 1e-5 * u**3 + 2 * v, u**2 - 3 * u * v + v**2


@distances
def test_the_real_map_between_nodes(nodes):
    """Points of a few rows, which share a grid, and scattered ones, which share none."""
    assert interpolated_map(cubic, 1) is cubic
    v, u = (a.astype(float) for a in np.mgrid[3:6, 3 - nodes:4 * nodes])
    rng = np.random.default_rng(1)
    scattered = rng.uniform(-nodes, 90 * nodes, 6), rng.uniform(0, 99, 6)
    seen = []
    for columns, rows in ((u, v), scattered, (u[0], 4.0)):
        def back_map(u, v):
            seen.append(np.size(u))
            assert not (u % nodes).any()
            return cubic(u, v)
        x, y = interpolated_map(back_map, nodes)(columns, rows)
        j = columns % nodes
        want = cubic(columns, np.asarray(rows))
        miss = 1e-5 * j * (j - nodes) * (j - nodes / 2)
        np.testing.assert_allclose(want[0] - x, miss, atol=1e-7)
        np.testing.assert_allclose(y, want[1], rtol=1e-9, atol=1e-7)
    # A grid of 8 nodes for each of 3 rows; four nodes for each scattered point; one row.
    assert seen == [3 * 8, 6, 6, 6, 6, 8]


def test_curvature_is_the_largest_miss_of_every_fourth_row():
    geometry = Geometry(130, 140, 130, 140)

    def back_map(u, v):
        return 1e-5 * u**3 * (v + 1), -1e-5 * u**3 * (v == 132) * 300

    def largest(nodes):
        j = np.arange(nodes)
        return 1e-5 * np.abs(j * (j - nodes) * (j - nodes / 2)).max()
    everything = ValidRows.everything(130, 140)
    # 130 columns: nodes 32 pixels apart still fit. Row 136 is the last of every fourth.
    assert curvature(back_map, geometry, everything) == {
        1: 0, **{nodes: pytest.approx(largest(nodes) * 300) for nodes in (8, 16, 32)}}
    assert curvature(back_map, geometry, everything, (8,)) == {8: pytest.approx(largest(8) * 300)}
    # Four valid rows, the first of which is looked at.
    for row in (0, 8, 72, 128, 136):
        spans = np.zeros((140, 4), int)
        spans[row:row + 4, 1] = 130
        assert curvature(back_map, geometry, ValidRows(spans), (16,)) == {
            16: pytest.approx(largest(16) * (row + 1))}
    assert curvature(back_map, geometry, ValidRows(0 * spans), (1, 16)) == {1: 0, 16: 0}
    narrow = Geometry(128, 140, 130, 140)
    assert set(curvature(back_map, narrow, ValidRows.everything(128, 140))) == {1, 8, 16}
    assert type(curvature(back_map, geometry, everything, (8,))[8]) is float


def test_the_largest_distance_within_the_limit():
    assert CURVATURE_LIMIT == .001
    assert largest_nodes({1: 0, 8: .001, 16: .00101, 32: .5}) == 8
    assert largest_nodes({1: 0, 8: .0002, 16: .00101}) == 8
    assert largest_nodes({8: .0011, 16: .01}) == 8
