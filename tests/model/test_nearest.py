"""Nearest points, compared with SciPy's tree."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from ncdc_model.nearest import Nearest


def scattered(count):
    return np.random.default_rng(count).normal(0, 100, (count, 2))


POINTS = {"one": scattered(1), "few": scattered(7), "many": scattered(900),
          "clustered": np.concatenate([scattered(300), 1e4 + scattered(40) / 1e3]),
          "on a line": np.stack([np.arange(200.0), np.full(200, 3.0)], axis=1),
          "at one position": np.ones((20, 2))}


@pytest.mark.parametrize("points", POINTS.values(), ids=POINTS)
def test_they_are_those_of_a_tree(points):
    positions = np.concatenate([points[:100], 3 * scattered(300), [(1e6, -1e6)]])
    for count in sorted({1, min(9, len(points)), min(32, len(points))}):
        distance, number = Nearest(points).query(positions, count)
        expected = cKDTree(points).query(positions, [*range(1, count + 1)])[0]
        np.testing.assert_allclose(distance, expected, rtol=1e-12, atol=1e-12)
        assert all(len(set(row)) == count for row in number.tolist())
        np.testing.assert_allclose(
            np.linalg.norm(points[number] - positions[:, None], axis=2), distance, rtol=1e-12)


@pytest.mark.parametrize("points", POINTS.values(), ids=POINTS)
def test_one_position_at_a_time(points):
    tree = Nearest(points)
    for position in np.concatenate([points[:20], 3 * scattered(40), [(1e5, -1e5)]]):
        distance, number = tree.nearest(position)
        assert distance == pytest.approx(cKDTree(points).query(position)[0], rel=1e-12)
        assert distance == pytest.approx(np.linalg.norm(points[number] - position), rel=1e-12)
