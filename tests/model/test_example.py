"""The built-in example: lens, photos, truth."""

import numpy as np
import pytest

from ncdc_model.example import (
    example_camera,
    noise_picture,
    page_dots,
    page_to_distorted,
    scene_photo,
    target_photo,
)
from ncdc_model.example.render import SUBSAMPLES, ideal_samples
from ncdc_model.images import demosaic
from ncdc_spec.geometry import Geometry


def test_part_of_the_frame_has_no_source_at_top_and_bottom_middle():
    camera = example_camera()
    u, v = np.meshgrid(np.arange(640), np.arange(480))
    source = Geometry(640, 480, 640, 480).window_inside(*camera.back_map(u, v))
    assert 0.05 < 1 - source.mean() < 0.15
    assert not source[0, 320] and not source[479, 320]
    assert source[0, 5] and source[479, 634] and source[240, 5]


def test_view_is_wide():
    left, right = example_camera().ray(np.array([0.0, 639.0]), np.array([239.5, 239.5]))
    assert 100 < np.degrees(np.arccos(left @ right)) < 110


def test_rendered_rays_are_those_of_the_lens():
    camera = example_camera()
    a, b = (field[::7, ::7] for field in ideal_samples(camera))
    offset = (np.arange(3) - 1) / SUBSAMPLES
    xs, ys = ((np.arange(size)[:, None] + offset).ravel()[::7] for size in (640, 480))
    x, y = camera.distort(a, b)
    assert np.abs(x - xs[None, :]).max() < 1e-4
    assert np.abs(y - ys[:, None]).max() < 1e-4


@pytest.mark.longer
def test_photos_are_raw_and_repeatable():
    camera = example_camera()
    first = target_photo(camera, seed=3)
    assert first.shape == (480, 640) and first.dtype == np.uint8
    np.testing.assert_array_equal(first, target_photo(camera, seed=3))
    assert (first != target_photo(camera, seed=4)).mean() > 0.3


def test_target_is_dark_at_the_dots_and_bright_between():
    camera = example_camera()
    photo = target_photo(camera)
    dots = page_to_distorted(camera, page_dots()).reshape(-1, 2)
    between = page_to_distorted(camera, page_dots() + 5.0).reshape(-1, 2)

    def brightness(points):
        inside = ((points > 2) & (points < (637, 477))).all(axis=1)
        x, y = np.round(points[inside]).astype(int).T
        assert len(x) > 250
        return photo[y, x].astype(int)
    assert brightness(dots).max() < 40 < 60 < brightness(between).min()


@pytest.mark.longer
def test_scene_is_raw_with_colours_and_detail():
    raw = scene_photo(example_camera())
    assert raw.shape == (480, 640) and raw.dtype == np.uint8
    picture = demosaic(raw).astype(int)
    assert (picture.max(axis=2) - picture.min(axis=2)).mean() > 30
    assert np.abs(np.diff(picture[:, :, 1], axis=1)).mean() > 5


def test_noise_picture():
    picture = noise_picture(40, 30, seed=5)
    assert picture.shape == (30, 40) and set(np.unique(picture)) == {0, 255}
    np.testing.assert_array_equal(picture, noise_picture(40, 30, seed=5))
    assert (picture != noise_picture(40, 30, seed=6)).mean() > 0.3
