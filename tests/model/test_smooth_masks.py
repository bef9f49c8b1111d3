"""Masks of smooth maps by cells, compared with those of every pixel."""

import numpy as np
import pytest

from lenses import lens
from ncdc_model.evaluate import float_map
from ncdc_model.golden.smooth_masks import smooth_masks
from ncdc_model.golden.valid import Calibrated, masks_of
from ncdc_spec.descriptor import FloatNetwork
from ncdc_spec.geometry import Geometry

SIZE = 320, 240


def assert_equal(back_map, geometry, seed=0):
    """Masks by both ways, with the covering of some points of the map."""
    rng = np.random.default_rng(seed)
    u, v = rng.uniform(60, 200, (2, 50))
    x, y = back_map(u, v)
    covering = Calibrated(u, v, x, y, 15.0).covering(geometry)
    expected, found = (masks(back_map, geometry, covering) for masks in (masks_of, smooth_masks))
    for name in ("inside", "unfolded", "covered"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name), name)
    return found


def network(seed, steep):
    """A random network whose sources leave the image, and which folds back."""
    rng = np.random.default_rng(seed)
    weights = steep * rng.uniform(-1, 1, (5, 2))
    output = rng.uniform(-90, 90, (2, 5)) + [[150 / steep], [0]]
    return FloatNetwork(weights, rng.uniform(-1, 1, 5), output, np.array([160.0, 120.0]),
                        skip_weights=np.array([[120.0, 0], [0, 90]]))


@pytest.mark.parametrize("corrected", [SIZE, (333, 17), (9, 250), (8, 8)])
def test_a_lens(corrected):
    geometry = Geometry(*corrected, *SIZE)
    camera = lens().framed(corrected, .4)
    masks = assert_equal(camera.back_map, geometry)
    assert corrected != SIZE or .1 < masks.inside.mean() < .9


@pytest.mark.parametrize("seed", range(12))
def test_networks_that_fold(seed):
    geometry = Geometry(*SIZE, *SIZE)
    masks = assert_equal(float_map(network(seed, 1 + seed / 4), geometry), geometry, seed)
    assert masks.inside.any()


def test_some_of_them_fold_indeed():
    geometry = Geometry(*SIZE, *SIZE)
    folded = [smooth_masks(float_map(network(seed, 1 + seed / 4), geometry), geometry)
              for seed in range(12)]
    assert sum((masks.inside & ~masks.unfolded).any() for masks in folded) >= 6
    assert all(masks.covered is None for masks in folded)


def test_most_pixels_are_not_evaluated():
    asked, camera = [], lens().framed((1280, 960))

    def counted(u, v):
        asked.append(np.size(u))
        return camera.back_map(u, v)
    smooth_masks(counted, Geometry(*camera.frame.size, *camera.size))
    assert sum(asked) < .5 * np.prod(camera.frame.size)
