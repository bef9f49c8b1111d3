"""The valid region: exactly the pixels with a source, without islands and folds."""

import numpy as np
import pytest

from ncdc_model.golden.valid import (
    Calibrated,
    grid_pitch,
    grown,
    lost_pixels,
    valid_mask,
    valid_rows,
)
from ncdc_model.lens import Camera
from ncdc_model.training.levenberg import train_levenberg
from ncdc_model.training.problem import Problem
from ncdc_spec.geometry import Geometry, ValidRows
from reference_lenses import reference_lens

GEOMETRY = Geometry(320, 240, 320, 240)


def barrel(width=320, height=240):
    """A strong barrel lens whose full width fills the corrected width."""
    return Camera.from_dict({"width": width, "height": height, "f_distorted": .475 * width,
                             "centre": [.502 * width, .49 * height], "p": [.002, -.001]})


def window_mask(map_function, geometry):
    v, u = np.indices(geometry.corrected[::-1]).astype(float)
    return geometry.window_inside(*map_function(u, v))


def test_fifteen_percent_without_source_give_exactly_the_true_mask():
    camera = barrel()
    truth = window_mask(camera.back_map, GEOMETRY)
    assert .10 < 1 - truth.mean() < .20
    rows = valid_rows(camera.back_map, GEOMETRY)
    np.testing.assert_array_equal(rows.mask(320), truth)
    assert lost_pixels(truth, rows) == 0
    assert (rows.spans[0, 2:] > 0).all()                     # two corners in the first row


@pytest.mark.parametrize("height", [127, 128, 129, 257])
def test_bands_of_rows_leave_no_seam(height):
    geometry = Geometry(320, height, 320, 240)

    def scaled(u, v):
        return barrel().back_map(u, v * 239 / (height - 1))
    np.testing.assert_array_equal(valid_mask(scaled, geometry), window_mask(scaled, geometry))


def test_an_island_that_falls_back_inside_is_dropped():
    def with_island(u, v):
        x, y = u + 0.0, v - 60.0
        island = (v < 20) & (u > 250)
        return np.where(island, u, x), np.where(island, v + 50, y)
    truth = np.zeros((240, 320), bool)
    truth[61:, 1:-1] = window_mask(lambda u, v: (u, v - 60.0), GEOMETRY)[61:, 1:-1]
    assert window_mask(with_island, GEOMETRY)[:20].any()
    np.testing.assert_array_equal(valid_mask(with_island, GEOMETRY), truth)


def test_a_fold_is_dropped():
    def folding(u, v):
        return 200 - np.abs(u - 199.25), v
    mask = valid_mask(folding, GEOMETRY)
    assert mask[120, 10:199].all() and not mask[120, 200:].any()
    assert window_mask(folding, GEOMETRY)[120, 200:].any()


def test_without_a_source_in_the_middle_the_largest_region_counts():
    def split(u, v):
        return np.where(np.abs(u - 180) < 40, np.nan, u), v
    mask = valid_mask(split, GEOMETRY)
    assert mask[120, 2:140].all() and not mask[:, 141:].any()


def test_no_source_at_all_gives_empty_rows():
    rows = valid_rows(lambda u, v: (u + 1000, v), GEOMETRY)
    assert not rows.mask(320).any()


def test_lost_pixels_counts_the_third_span():
    mask = np.zeros((8, 320), bool)
    mask[3, 10:20] = mask[3, 30:37] = mask[3, 50:100] = True
    assert lost_pixels(mask, ValidRows.of_mask(mask)) == 7


def test_pitch_is_that_of_each_photo():
    u, v = (g.ravel() for g in np.meshgrid(np.arange(0, 300, 30.0), np.arange(0, 200, 30.0)))
    assert grid_pitch([(u, v), (u + 1, v)]) == 30
    assert grid_pitch([(u[:1], v[:1])]) == 0


def test_points_cover_their_hull_and_two_pitches():
    u, v = (g.ravel() for g in np.meshgrid(np.arange(100, 221, 20.0), np.arange(80, 161, 20.0)))
    hole = (u == 160) & (v == 120)                          # a missing dot costs nothing
    u, v = u[~hole], v[~hole]
    mask = Calibrated(u, v, u, v, 40.0).mask(lambda u, v: (u, v), GEOMETRY)
    ys, xs = np.nonzero(mask)
    assert (xs.min(), xs.max(), ys.min(), ys.max()) == (60, 260, 40, 200)
    assert mask[80:161, 100:221].all() and not mask[45, 65]


def test_points_outside_the_frame_cover_its_edge():
    u, v = (g.ravel() for g in np.meshgrid(np.arange(-10, 340, 20.0), np.arange(-10, 260, 20.0)))
    inside = (u > -15) & (v > -15)
    x, y = np.clip(u, 0, 319), np.clip(v, 0, 239)
    mask = Calibrated(u[inside], v[inside], x[inside], y[inside], 15.0).mask(
        lambda u, v: (u, v), GEOMETRY)
    np.testing.assert_array_equal(mask, window_mask(lambda u, v: (u, v), GEOMETRY))


@pytest.mark.longer
def test_network_trained_on_dots_finds_nearly_the_true_region():
    camera = barrel()
    truth = window_mask(camera.back_map, GEOMETRY)
    u, v = (g.ravel() for g in np.meshgrid(np.linspace(5, 314, 26), np.linspace(5, 234, 19)))
    x, y = camera.back_map(u, v)
    seen = (x > 4) & (x < 315) & (y > 4) & (y < 235)
    u, v, x, y = u[seen], v[seen], x[seen], y[seen]
    network, _ = train_levenberg(Problem(u, v, x, y, GEOMETRY), 8, starts=24, rounds=1)

    def back_map(u, v):
        return network(*GEOMETRY.normalise(u, v))
    covered = Calibrated(u, v, x, y, 2 * grid_pitch([(u, v)])).mask(back_map, GEOMETRY)
    mask = valid_mask(back_map, GEOMETRY, covered)
    assert (mask != truth).mean() < .004


@pytest.mark.regress
def test_extrapolation_of_a_real_lens_network_is_cut_off():
    dots, _ = reference_lens("120kb")
    geometry = dots.geometry
    network, _ = train_levenberg(dots, 8, starts=24, rounds=1)

    def back_map(u, v):
        return network(*geometry.normalise(u, v))
    reach = 2 * grid_pitch([(dots.u, dots.v)])
    covered = Calibrated(dots.u, dots.v, dots.x, dots.y, reach).mask(back_map, geometry)
    region = valid_mask(back_map, geometry, covered)
    assert 0 < region.sum() <= window_mask(back_map, geometry).sum()
    assert .80 < region.mean() < .87                          # the true share is 83 %


def test_grown_adds_a_rim():
    mask = np.zeros((40, 60), bool)
    mask[20, 30] = True
    v, u = np.indices(mask.shape)
    np.testing.assert_array_equal(grown(mask, 5), np.hypot(u - 30, v - 20) <= 5)
    assert not grown(mask & False, 5).any()
