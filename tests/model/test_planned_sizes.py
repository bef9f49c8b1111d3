"""A trained map for pictures of another size, as the planner takes it."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.planner.lookups import frame_windows
from ncdc_model.planner.scaled import hardware_takes, scaled
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import GRADIENT


@pytest.fixture(scope="module")
def trained():
    return barrel_descriptor((48, 40), (48, 60), interpolation=GRADIENT)


@pytest.mark.parametrize("size", [(96, 80), (144, 60), (7680, 4320)])
def test_a_pixel_shows_the_point_that_the_trained_picture_has_there(trained, size):
    """Pixel (u, v) of the larger picture is at ((u + 1/2) / k - 1/2) of the trained one."""
    large = scaled(trained, size)
    factors = np.array(size) / (48, 40)
    assert large.geometry.distorted == (size[0], 60 * size[1] // 40)
    rng = np.random.default_rng(3)
    at = rng.uniform(0, 1, (100, 2)) * size
    x, y = large.exact_network(*large.geometry.normalise(*at.T))
    small = (at + .5) / factors - .5
    there = np.stack(trained.exact_network(*trained.geometry.normalise(*small.T)), axis=1)
    expected = (there + .5) * factors - .5
    # The weights of the larger picture are rounded: 24 bits of a number of so many pixels.
    assert np.abs(np.stack([x, y], axis=1) - expected).max() < 2e-5 * max(size)


def test_valid_pixels_are_those_at_the_same_position(trained):
    large = scaled(trained, (144, 120))
    mask, trained_mask = large.valid.mask(144), trained.valid.mask(48)
    assert np.array_equal(mask, trained_mask.repeat(3, axis=0).repeat(3, axis=1))
    assert not mask.all()


def test_windows_of_the_same_size_are_those_of_the_trained_map(trained):
    same, own = frame_windows(scaled(trained, (48, 40))), frame_windows(trained)
    for name in ("x0", "y0", "used"):
        assert np.array_equal(getattr(same, name), getattr(own, name))


def test_what_a_format_does_not_hold_gets_a_wider_one(trained):
    large = scaled(trained, (8192, 4320))
    assert large.formats.output_weight.i_bits > trained.formats.output_weight.i_bits
    assert large.formats.coordinate.i_bits > trained.formats.coordinate.i_bits   # 8192 columns
    assert not hardware_takes(large.geometry)
    assert hardware_takes(scaled(trained, (2048, 1024)).geometry)


@pytest.mark.parametrize("size,message", [
    ((8193, 100), "the width to plan is 8193, the limits are 8 and 8192"),
    ((100, 7), "the height to plan is 7, the limits are 8 and 8192"),
    ((100, 8192), "distorted_height is 12288, the limits are 8 and 8192")])
def test_sizes_beyond_the_limits_are_rejected(trained, size, message):
    with pytest.raises(InputError, match=message):
        scaled(trained, size)


def test_a_picture_too_narrow_for_its_nodes_is_rejected(trained):
    with pytest.raises(InputError, match="nodes"):
        scaled(replace(trained, nodes=32), (16, 16))
