"""A step across a gap of the lattice: two sheets make one, no lens does."""

import numpy as np
import pytest

from ncdc_bench.photos.lens import Lens, Plane
from ncdc_bench.photos.targets import Pose
from ncdc_model.calibration.seams import find_seam, steps
from ncdc_model.calibration.smooth import fit_smooth

SIZE = 1280, 960
BUMPS = ((400, 300), 3.6, 70, (1, 0.3)), ((900, 600), 2.5, 110, (-0.4, 1))


def page(columns, rows, step, view=0.42, noise=0.05):
    """Index, and pixels of the points that a wide lens sees."""
    index = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
    plane = Plane(Pose((0.05, 0.0), step, 4.0, (9.0, -7.0)), (columns, rows))
    xy = Lens(view * SIZE[0], (642.5, 475.5)).pixels(plane.rays(index))
    xy = xy + np.random.default_rng(0).normal(0, noise, xy.shape)
    seen = ((xy > 0) & (xy < np.array(SIZE) - 1)).all(axis=1)
    return index[seen] - index[seen].min(axis=0), xy[seen]


def seam_of(index, xy):
    few = np.random.default_rng(1).permutation(len(xy))[:80]
    rest = xy - fit_smooth(SIZE, [(index[few], xy[few])]).pixels(0, index)
    return find_seam(index, xy, rest, SIZE[0])


def bumped(xy):
    """A lens that is uneven at two positions, by 3.6 and 2.5 pixels."""
    out = xy.copy()
    for middle, high, wide, way in BUMPS:
        out += high * np.exp(-((xy - middle)**2).sum(axis=1) / 2 / wide**2)[:, None] * way
    return out


@pytest.mark.parametrize("columns,rows,step", [
    pytest.param(25, 19, 0.1, marks=pytest.mark.longer), (11, 8, 0.21)])
def test_two_sheets_are_found_with_their_position_and_step(columns, rows, step):
    index, xy = page(columns, rows, step)
    right = xy[:, 0] > 640
    xy[right] += (1.0, 3.0)
    seam = seam_of(index, xy)
    assert seam.axis == 0 and np.linalg.norm(seam.step - (1.0, 3.0)) < 0.5
    spacing = np.median(np.diff(np.sort(xy[index[:, 1] == index[:, 1].max() // 2][:, 0])))
    assert np.abs(seam.ends[:, 0] - 640).max() < 1.5 * spacing


@pytest.mark.longer
def test_a_sheet_below_is_found():
    index, xy = page(25, 19, 0.1)
    xy[xy[:, 1] > 500] += (-2.0, 1.5)
    assert seam_of(index, xy).axis == 1


@pytest.mark.parametrize("view", [0.42, 0.34])
@pytest.mark.parametrize("columns,rows,step", [
    pytest.param(25, 19, 0.12, marks=pytest.mark.longer), (11, 8, 0.21)])
def test_a_lens_makes_none_even_if_it_is_uneven(columns, rows, step, view):
    index, xy = page(columns, rows, step, view)
    assert seam_of(index, xy) is None
    assert seam_of(index, bumped(xy)) is None


def test_a_page_in_waves_has_no_seam():
    index, xy = page(25, 19, 0.1)
    xy[:, 1] += 1.5 * np.sin(index[:, 0] * 2 * np.pi / 5)
    assert seam_of(index, xy) is None


def test_the_step_across_each_gap_is_measured():
    index, xy = page(12, 8, 0.15, noise=0.0)
    flat = index * 10.0
    flat[index[:, 0] > 5] += (0.0, 2.0)
    step, gain = steps(index, flat, 0)
    np.testing.assert_allclose(step[5], np.broadcast_to((0.0, 2.0), step[5].shape), atol=1e-9)
    assert np.isfinite(gain[5]).all() and gain[5].min() > 0.5
