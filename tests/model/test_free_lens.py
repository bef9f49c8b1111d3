"""How far the points of a page determine the lens beyond them, compared with OpenCV's model."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
import pytest
from scipy.optimize import least_squares

from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.golden.smooth_masks import smooth_masks
from ncdc_model.golden.valid import connected
from ncdc_model.training import free_lens
from ncdc_model.training import region as regions
from ncdc_model.training.region import region_of
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import Geometry

SIZE = 640, 480
CAMERA = np.array([[380.0, 0, 323.0], [0, 380.0, 236.0], [0, 0, 1]])
BARREL = np.array([-0.26, 0.08, -0.003, 0.002, -0.01])
TURN = np.radians([4.0, -5.0, 3.0])


@pytest.fixture(autouse=True)
def few_pixels(monkeypatch):
    """A tenth of the compared pixels: they take most of the time."""
    monkeypatch.setattr(regions, "_STEP", 48)
    monkeypatch.setattr(regions, "_BORDER", 400)


def project(plane, coefficients=BARREL):
    """Pixels (n, 2) of points (n, 2) of the plane z = 1."""
    rays = np.column_stack([plane, np.ones(len(plane))])
    return cv2.projectPoints(rays[:, None], np.zeros(3), np.zeros(3), CAMERA,
                             coefficients)[0].reshape(-1, 2)


@cache
def calibrated(share, aside=0.0):
    """Frame of a page of that share of the width, ``aside`` of its own width to the right, and the
    pixels in the picture by the smooth lens."""
    i, j = np.meshgrid(np.arange(28), np.arange(21))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    edge = cv2.undistortPoints(np.array([[[323.0 + 320 * share, 236.0]]]), CAMERA, BARREL)[0, 0, 0]
    shift = np.array([2 * aside * edge, 0, 1])
    page = np.column_stack([(index - (13.5, 10)) * edge / 13.5, np.zeros(len(index))])
    rays = page @ cv2.Rodrigues(TURN)[0].T + shift
    # Far points of the page are seen once more, beyond the fold of the model.
    near = np.hypot(*(rays[:, :2] / rays[:, 2:]).T) < 1.9
    xy = project(rays[:, :2] / rays[:, 2:])
    xy = np.round(xy + np.random.default_rng(3).normal(0, 0.02, xy.shape), 4)
    seen = near & ((xy > 3) & (xy < np.array(SIZE) - 4)).all(axis=1)
    photo = PhotoPoints(index[seen] - index[seen].min(axis=0), xy[seen], np.zeros(seen.sum()),
                        name="page.png")
    frame = ideal_frame(TargetPoints("chessboard", SIZE, (photo,)))
    inside = connected(smooth_masks(frame.camera.back_map, Geometry(*SIZE, *SIZE)).unfolded)
    return frame, inside


def true_error(back_map, u, v):
    """Distances (n,) of a map from the true lens, the homography free."""
    goal = np.stack(back_map(u, v), axis=1)
    flat = np.column_stack([(u - 320) / 640, (v - 240) / 640, np.ones(len(u))])

    def off(numbers):
        rays = flat @ np.append(numbers, 1.0).reshape(3, 3).T
        return project(rays[:, :2] / rays[:, 2:]) - goal
    some = slice(None, None, 7)
    start = np.array([640 / 380, 0, 0, 0, 640 / 380, 0, 0, 0])
    best = least_squares(lambda p: off(p)[some].ravel(), start)
    return np.linalg.norm(off(best.x), axis=1)


def test_the_slopes_are_those_of_the_pixels():
    radial, rng = free_lens._Radial(1.1), np.random.default_rng(2)
    vector = np.concatenate([[np.log(350.0), 310, 250], 0.01 * rng.normal(size=3), np.zeros(9),
                             [.001, -.002, .1, .2, .001, .002, .02, -.03, .01, .005],
                             [.1, -.2, .05, -3, -2, 9]])
    cells, owner = rng.uniform(0, 8, (30, 2)), np.zeros(30, int)
    slopes = radial.slopes(vector, cells, owner)

    def pixels(vector):
        return radial.seen(vector, free_lens._rays(vector, cells, owner))
    for k in range(len(vector)):
        step = 1e-6 * np.eye(len(vector))[k]
        numeric = (pixels(vector + step) - pixels(vector - step)) / 2e-6
        np.testing.assert_allclose(slopes[:, :, k], numeric, atol=1e-3 + 1e-5 * abs(numeric).max())


@pytest.mark.parametrize("share", [0.55, 0.65, pytest.param(0.75, marks=pytest.mark.longer)])
def test_beyond_the_points_the_error_is_what_it_is_said_to_be(share):
    frame, inside = calibrated(share)
    region = region_of(frame, inside)
    true = true_error(frame.camera.back_map, region.u, region.v)
    whole, beyond = region.errors(frame.camera.back_map)
    assert true.max() > 1 and true[~region.beyond].max() < 0.7 * true.max()
    assert true.max() <= whole["max"] == beyond["max"] and region.uncertain >= true.max()
    percent = f"{100 * region.beyond_part:.0f} % of the picture lies beyond the outermost points, "
    assert region.warning(SIZE[0]).startswith(percent) and region.beyond_part > 0.4
    assert "on all sides; its error is not known better than" in region.warning(SIZE[0])


def test_a_page_that_fills_the_picture_determines_the_lens():
    frame, inside = calibrated(1.3)
    region = region_of(frame, inside)
    true = true_error(frame.camera.back_map, region.u, region.v)
    whole, _ = region.errors(frame.camera.back_map)
    rms = float(np.sqrt(np.mean(true[~region.border]**2)))
    assert whole["mse"]**.5 == pytest.approx(rms, rel=0.25, abs=0.01)
    assert true.max() <= whole["max"] < 0.5
    assert region.warning(SIZE[0]) == ""


def test_the_side_is_named():
    region = region_of(*calibrated(0.6, aside=0.3))
    assert "points, most of it on the left; " in region.warning(SIZE[0])
    mirrored = replace(region, x=SIZE[0] - 1 - region.x)
    assert "points, most of it on the right; " in mirrored.warning(SIZE[0])


def test_what_is_less_certain_is_left_out():
    frame, inside = calibrated(0.65)
    whole, region = region_of(frame, inside), region_of(frame, inside, 1.0)
    assert whole.uncertain > 5 and 0.8 < region.uncertain < 1.1
    assert 0.2 * inside.sum() < (inside & region.certain).sum() < 0.8 * inside.sum()
    assert region.certain[region.v, region.u].all()
    left = true_error(frame.camera.back_map, region.u, region.v)
    assert left.max() <= region.errors(frame.camera.back_map)[0]["max"] < 2
    with pytest.raises(InputError, match=r"0\.0 % of the corrected frame is known to 1e-06 px"):
        region_of(frame, inside, 1e-6)


def test_the_bound_is_a_picture():
    frame, inside = calibrated(0.65)
    region = region_of(frame, inside)
    bound = region.bound(frame.camera.back_map, inside)
    assert bound.shape == SIZE[::-1]
    even = ~region.border
    far = np.hypot(*np.subtract(frame.camera.back_map(region.u, region.v), (region.x, region.y)))
    np.testing.assert_allclose(bound[region.v, region.u][even], (far + 3 * region.sigma)[even])
    assert np.nanmax(bound) > 20 * np.nanmin(bound) and not np.isfinite(bound[~inside]).any()
