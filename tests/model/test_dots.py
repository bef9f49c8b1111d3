"""Dot pages: detection compared with exact truth, and on real photos."""

import numpy as np
import pytest

from ncdc_model.calibration.dots import find_dots
from ncdc_model.calibration.lattice import find_lattices
from ncdc_model.example import example_camera, page_dots, page_to_distorted, target_photo
from ncdc_model.example.target import RADIUS
from ncdc_model.images import mosaic, read_image
from ncdc_spec.errors import InputError
from photos import full_photos, photos


@pytest.fixture(scope="module")
def camera():
    return example_camera()


@pytest.fixture(scope="module")
def photo(camera):
    return target_photo(camera)


def truth(camera):
    """Exact centres (rows, columns, 2), and which dots lie wholly in the frame."""
    turns = np.linspace(0, 2 * np.pi, 24, endpoint=False)
    rim = page_dots()[:, :, None] + RADIUS * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    rim = page_to_distorted(camera, rim)
    # A dot whose blurred rim reaches the first or last pixel counts as cut.
    whole = ((rim > 1.5) & (rim < np.array(camera.size) - 2.5)).all(axis=(2, 3))
    return page_to_distorted(camera, page_dots()), whole


@pytest.mark.longer
def test_every_whole_dot_is_found_where_it_is(camera, photo):
    found = find_dots(photo).whole
    centres, whole = truth(camera)
    # The index counts from the first visible column and row: one shift for all.
    flat = centres.reshape(-1, 2)
    nearest = np.linalg.norm(flat[None] - found.xy[:, None], axis=2).argmin(axis=1)
    j, i = np.unravel_index(nearest, whole.shape)
    shift = np.stack([i, j], axis=1) - found.index
    assert (shift == shift[0]).all()
    missed = whole.ravel() & ~np.isin(np.arange(whole.size), nearest)
    assert not missed.any(), flat[missed]
    error = np.linalg.norm(found.xy - centres[j, i], axis=1)
    assert np.sqrt(np.mean(error**2)) < 0.1
    assert error.max() < 0.3


def test_cut_dots_are_recovered(camera, photo):
    found = find_dots(photo)
    centres, whole = truth(camera)
    flat = centres.reshape(-1, 2)
    distance = np.linalg.norm(flat[None] - found.xy[:, None], axis=2)
    nearest = distance.argmin(axis=1)
    j, i = np.unravel_index(nearest, whole.shape)
    shift = np.stack([i, j], axis=1) - found.index
    assert (shift == shift[0]).all()
    seen = ((flat >= -0.5) & (flat <= np.array(camera.size) - 0.5)).all(axis=1)
    missed = seen & ~np.isin(np.arange(whole.size), nearest)
    assert found.cut.sum() >= 20 and missed.sum() <= 3
    error = distance.min(axis=1)[found.cut]
    assert np.sqrt(np.mean(error**2)) < 0.12 and error.max() < 0.25


def test_areas_are_those_of_the_dots(camera, photo):
    found = find_dots(photo)
    middle = np.linalg.norm(found.xy - (320, 240), axis=1).argmin()
    a, b = camera.undistort(*found.xy[middle])
    h = 1e-4
    x, y = camera.distort(a + h * np.array([0, 1, 0]), b + h * np.array([0, 0, 1]))
    stretch = abs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0])) / h**2
    assert found.area[middle] == pytest.approx(np.pi * (RADIUS * 0.012)**2 * stretch, rel=0.15)


@pytest.mark.longer
def test_colour_and_grey_photos_give_the_same_dots(photo):
    colour, grey = find_dots(np.dstack([photo] * 3)).whole, find_dots(photo).whole
    nearest = np.linalg.norm(colour.xy[:, None] - grey.xy[None], axis=2).min(axis=1)
    assert abs(len(colour.index) - len(grey.index)) <= 2 and np.quantile(nearest, 0.99) < 0.1


@pytest.mark.longer
def test_raw_frame_with_strong_colour_cast(photo):
    rgb = np.stack([photo * 0.5, photo * 1.0, photo * 0.35], axis=-1).astype(np.uint8)
    cast, plain = find_dots(mosaic(rgb)), find_dots(photo)
    np.testing.assert_array_equal(cast.index, plain.index)
    assert np.abs(cast.xy - plain.xy)[~plain.cut].max() < 0.25


@pytest.mark.longer
def test_rejected_blobs_are_counted_by_reason(photo):
    stained = photo.copy()
    stained[100:104, 200:420] = 5           # a scratch that joins dots
    found = find_dots(stained)
    assert found.rejected["cut by the border"] > 10
    assert "not a filled ellipse" in found.rejected
    assert len(found.index) < len(find_dots(photo).index)


@pytest.mark.parametrize("level", [0, 128])
def test_photo_without_dots(level):
    with pytest.raises(InputError, match="0 dots on one lattice were found, at least 25"):
        find_dots(np.full((120, 160), level, np.uint8))


def test_noise_is_no_page_of_dots():
    noise = np.random.default_rng(2).integers(0, 256, (240, 320)).astype(np.uint8)
    with pytest.raises(InputError, match="dots on one lattice were found"):
        find_dots(noise)


def lattice(seed):
    """A barrel-distorted lattice in random order, with its true indices."""
    rng = np.random.default_rng(seed)
    i, j = np.meshgrid(np.arange(15), np.arange(11))
    index = np.stack([i.ravel(), j.ravel()], axis=1)[rng.permutation(165)]
    flat = (index - (7, 5)) * 30.0 @ np.array([[0.99, 0.14], [-0.14, 0.99]])
    r2 = (flat**2).sum(axis=1, keepdims=True) / 250**2
    return index, 300 + flat * (1 - 0.18 * r2) + rng.normal(0, 0.3, flat.shape)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_lattice_with_holes_and_strays(seed):
    index, xy = lattice(seed)
    rng = np.random.default_rng(seed + 10)
    keep = rng.random(165) > 0.06
    strays = rng.uniform(xy.min(axis=0), xy.max(axis=0), (12, 2))
    largest, *_ = find_lattices(np.vstack([xy[keep], strays]), (300, 300))
    where, found = largest.where, largest.index
    real = where < keep.sum()
    assert real.sum() > 0.95 * keep.sum()
    shift = index[keep][where[real]] - found[real]
    assert (shift == shift[0]).all()
    assert len(np.unique(found, axis=0)) == len(found)


def test_displaced_point_loses_its_number():
    index, xy = lattice(4)
    victim = int(np.flatnonzero((index == (9, 6)).all(axis=1))[0])
    xy[victim] += (7.5, 0)                  # a quarter of the pitch: within reach of the walk
    largest, *_ = find_lattices(xy, (300, 300))
    assert victim not in largest.where and len(largest.dropped) >= 1
    assert len(largest.where) == 164


@pytest.mark.longer
@pytest.mark.parametrize("where", [
    photos, pytest.param(full_photos, marks=pytest.mark.regress)], ids=["small", "full"])
@pytest.mark.parametrize("name,dots", [("dot_pattern_06.jpg", 1958), ("dot_pattern_05.jpg", 4512)])
def test_real_dot_pages(where, name, dots):
    found = find_dots(read_image(where(f"dots/{name}")[0]))
    assert len(found.index) >= dots
    # No wrong number: the step from dot to dot changes slowly all over the page.
    points = {tuple(key): point for key, point in zip(found.index.tolist(), found.xy)}
    bends = [np.linalg.norm(points[i - 1, j] + points[i + 1, j] - 2 * points[i, j])
             / np.linalg.norm(points[i + 1, j] - points[i, j])
             for i, j in points if (i - 1, j) in points and (i + 1, j) in points]
    assert len(bends) > 0.9 * dots and max(bends) < 0.25


@pytest.mark.longer
def test_more_dots_than_opencv_takes_rows_in_a_call():
    """Rings around 11,200 dots are 33,600 rows of samples."""
    columns, rows, step, samples = 112, 100, 9.0, 4
    offset = (np.arange(samples) + 0.5) / samples - 0.5
    x, y = ((np.arange(int(step * (count + 1)))[:, None] + offset).ravel()
            for count in (columns, rows))
    dx, dy = (value - step * np.clip(np.rint(value / step), 1, count)
              for value, count in ((x, columns), (y, rows)))
    page = np.where(dy[:, None]**2 + dx**2 < 2.6**2, 30.0, 220.0)
    page = page.reshape(len(y) // samples, samples, -1, samples).mean(axis=(1, 3))
    found = find_dots(np.rint(page).astype(np.uint8))
    assert len(found.index) == columns * rows
    np.testing.assert_allclose(found.xy, step * (found.index + 1), atol=0.05)
