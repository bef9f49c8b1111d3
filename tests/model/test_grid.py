"""Even Bayer grids: known truth, sizes, limits."""

import numpy as np
import pytest

from ncdc_spec.errors import InputError
from ncdc_spec.sensors.grid import binned, evened, grid_size, grid_weight, gridded


def positions(count, reduction):
    """Active pixel, from the middle of a skipping sensor's first pair, of each of its samples."""
    index = np.arange(count)
    return 2 * reduction * (index // 2) + index % 2


def even_positions(count, reduction):
    return reduction * np.arange(count) + (1 - reduction) / 2


def ramp(across, down, slopes):
    """Samples of a plane of grey."""
    return 600 + slopes[0] * across + slopes[1] * down[:, None]


@pytest.mark.parametrize("slopes", [(8, 0), (0, 8), (-8, 8), (16, -24)])
@pytest.mark.parametrize("reduction,weight", [(1, 0), (2, 2), (4, 3)])
def test_a_plane_is_that_of_the_even_grid(reduction, weight, slopes):
    """Exactly: these slopes leave nothing to round."""
    size = 12, 10
    sent = ramp(*(positions(count, reduction) for count in size), slopes)
    assert grid_weight(reduction) == weight
    found = evened(sent - sent.min(), weight) + sent.min()
    true = ramp(*(even_positions(count, reduction) for count in size), slopes)
    moved = slice(2, None) if weight else slice(None)
    assert np.array_equal(found[moved, moved], true[:found.shape[0], :found.shape[1]][moved, moved])
    assert found.shape == ((8, 10) if weight else (10, 12))


def test_binning_of_a_skipping_sensor_is_the_reduction_of_both():
    """By 2 in the sensor and by 2 in capture: the grid of a reduction by 4."""
    sent = ramp(positions(32, 2), positions(24, 2), (8, 16))
    true = ramp(even_positions(16, 4) + 2, even_positions(12, 4) + 2, (8, 16))
    assert np.array_equal(gridded(sent, 3, 1)[2:, 2:], true[2:-2, 2:-2])


def test_evened_by_hand():
    row = np.array([0, 0, 100, 40, 300, 80, 1000, 500])
    found = evened(np.tile(row, (5, 1)), 2)[2]
    # Index 2: 100 + 2 (4 (0 - 40) + 2 (100 - 300) + (0 - 300)) / 128 = 86.56; index 3:
    # 40 + 2 (4 (300 - 100) + 2 (40 - 0) + (80 - 0)) / 128 = 55; index 4: 300 - 2 * 2460 / 128 =
    # 261.56; index 5: 80 + 2 * 3340 / 128 = 132.19.
    assert found.tolist() == [0, 0, 87, 55, 262, 132]


def test_ends_at_black_and_white():
    row = np.array([4095, 4095, 0, 4095, 4095, 0, 0, 0, 4095, 4095, 4095, 4095])
    found = evened(np.tile(row, (5, 1)), 3)
    assert found.min() == 0 and found.max() == 4095


def test_rows_are_rounded_before_columns():
    """The other order differs here and there by one."""
    samples = np.random.default_rng(5).integers(1500, 2500, (20, 22))
    difference = evened(samples, 3) - evened(samples.T, 3).T
    assert np.abs(difference).max() == 1
    down = [evened(np.tile(row, (5, 1)), 3)[2] for row in samples]
    across = [evened(np.tile(row, (5, 1)), 3)[2] for row in np.transpose(down)]
    assert np.array_equal(evened(samples, 3), np.transpose(across))


def test_first_samples_keep_their_values():
    samples = np.random.default_rng(6).integers(0, 4096, (9, 8))
    found = evened(samples, 3)
    assert np.array_equal(found[:2, :2], samples[:2, :2])
    assert (found[2:] != samples[2:-2, :-2]).any(axis=1).all()


def test_weight_of_zero_leaves_a_frame_as_it_is():
    samples = np.random.default_rng(7).integers(0, 4096, (9, 8))
    assert np.array_equal(evened(samples, 0), samples)


def test_binned_by_hand():
    rows = np.arange(4)[:, None] * 1000 + np.array([0, 7, 2, 8, 50, 60, 71])
    # Columns 0 and 2, 1 and 3, 4 and 6; rows 0 and 2, 1 and 3; halves up.
    assert binned(rows).tolist() == [[1001, 1008, 1061], [2001, 2008, 2061]]


@pytest.mark.parametrize("size", [(644, 484), (1296, 972), (27, 30), (8, 9), (29, 5)])
@pytest.mark.parametrize("weight", [0, 2])
@pytest.mark.parametrize("binning", [0, 1])
def test_size(size, weight, binning):
    found = gridded(np.zeros(size[::-1], int), weight, binning)
    assert found.shape[::-1] == grid_size(size, weight, binning)


def test_sizes_of_boards():
    assert grid_size((644, 484), 3, 0) == (642, 482)
    assert grid_size((1296, 972), 3, 1) == (646, 484)


@pytest.mark.parametrize("call,sentence", [
    (lambda: grid_weight(0), "the reduction is 0, it must be an integer of 1 to 7"),
    (lambda: grid_weight(8), "the reduction is 8, it must be an integer of 1 to 7"),
    (lambda: grid_weight(1.5), "the reduction is 1.5, it must be an integer of 1 to 7"),
    (lambda: evened([[0]], 4), "the grid weight is 4, it must be an integer of 0 to 3"),
    (lambda: evened([[4096]], 1), "samples of 4096 to 4096, they must be of 0 to 4095"),
    (lambda: binned([[-1]]), "samples of -1 to -1, they must be of 0 to 4095"),
    (lambda: binned([1]), "a frame of samples has 2 axes, this one has 1")])
def test_what_is_out_of_range(call, sentence):
    with pytest.raises(InputError, match=sentence):
        call()


def test_weight_is_the_nearest():
    for reduction in range(1, 8):
        assert abs(grid_weight(reduction) - 4 * (reduction - 1) / reduction) <= .5
