"""The ideal frame: training pairs compared with truth, straightness, real photos."""

import numpy as np
import pytest

from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.calibration.quality import Dropped, check_share
from ncdc_model.calibration.straightness import straightness
from ncdc_model.example import example_camera, page_dots, page_to_distorted, target_photo
from ncdc_model.images import read_image
from ncdc_model.lens import Camera, rotation
from ncdc_spec.errors import InputError
from photos import full_photos, photos


@pytest.fixture(scope="module")
def points():
    return detect_points([("page.png", target_photo(example_camera()))], "dots")


@pytest.fixture(scope="module")
def frame(points):
    return ideal_frame(points)


def projective_fit(source, target):
    """Homography from ``source`` to ``target`` (n, 2), and the distances (n,) that it leaves."""
    middle, size = source.mean(axis=0), source.std()
    plane = np.column_stack([(source - middle) / size, np.ones(len(source))])
    nothing = np.zeros_like(plane)
    system = np.vstack([np.hstack([plane, nothing, -target[:, :1] * plane]),
                        np.hstack([nothing, plane, -target[:, 1:] * plane])])
    matrix = np.linalg.svd(system, full_matrices=False)[2][-1].reshape(3, 3)
    image = plane @ matrix.T
    return matrix / matrix[2, 2], np.linalg.norm(image[:, :2] / image[:, 2:] - target, axis=1)


@pytest.mark.longer
def test_corrected_points_are_a_plane_view_of_the_scene(frame):
    """A true pinhole view of a plane: projective to the truth, hardly tilted, not stretched."""
    ideal = np.stack(example_camera().undistort(*frame.distorted.T), axis=1)
    matrix, left = projective_fit(frame.corrected, ideal)
    assert np.sqrt(np.mean(left**2)) * 250 < 0.15          # 250 corrected pixels per unit
    # Keystone: change of magnification over the standard deviation of the points.
    assert np.abs(matrix[2, :2]).max() < 0.03
    assert matrix[0, 0] == pytest.approx(matrix[1, 1], rel=0.02)
    assert abs(matrix[0, 1]) + abs(matrix[1, 0]) < 0.02 * matrix[0, 0]


@pytest.mark.longer
def test_dot_size_correction_moves_the_points_nearer_to_the_truth(points, frame):
    exact = page_to_distorted(example_camera(), page_dots()).reshape(-1, 2)

    def rms(xy):
        return np.sqrt(np.mean(((xy[:, None] - exact[None])**2).sum(axis=2).min(axis=1)))
    assert rms(frame.distorted) < 0.6 * rms(points.photos[0].xy)
    assert rms(frame.distorted) < 0.04


def test_homography_takes_the_index_to_corrected_pixels(frame):
    image = np.column_stack([frame.index, np.ones(len(frame.index))]) @ frame.homographies[0].T
    np.testing.assert_allclose(image[:, :2] / image[:, 2:], frame.corrected, atol=1e-6)


def test_smooth_lens_describes_the_points(frame):
    x, y = frame.camera.back_map(*frame.corrected.T)
    distance = np.linalg.norm(np.stack([x, y], axis=1) - frame.distorted, axis=1)
    assert frame.rms == pytest.approx(np.sqrt(np.mean(distance**2)), abs=1e-6)
    assert frame.rms < 0.6


def test_zoom_fit_fills_the_width(frame):
    assert frame.camera.frame.size == (640, 480)
    u, _ = frame.camera.corrected(np.array([0.0, 639.0]), np.array([239.5, 239.5]))
    np.testing.assert_allclose(u, (0, 639), atol=1e-6)
    u, v = frame.corrected.T
    assert np.ptp(u) > 600 and np.ptp(v) > 420


def test_points_far_outside_the_frame_are_left_out(points):
    close = ideal_frame(points, size=(320, 240), zoom=1.5)
    assert close.rejected[Dropped.OUTSIDE] > 200
    assert len(close.index) + sum(close.rejected.values()) == points.count
    assert (close.corrected > (-16.1, -12.1)).all() and (close.corrected < (335.1, 251.1)).all()


@pytest.mark.longer
def test_grossly_wrong_points_are_rejected(points):
    photo = points.photos[0]
    xy = photo.xy.copy()
    victims = np.flatnonzero(np.linalg.norm(xy - (320, 240), axis=1) < 120)[[3, 15, 28]]
    xy[victims] += ((9, 0), (0, -8), (6, 6))
    damaged = TargetPoints("dots", points.size, (PhotoPoints(photo.index, xy, photo.area),))
    frame = ideal_frame(damaged)
    assert frame.rejected[Dropped.GROSS] == 3
    remaining = {tuple(key) for key in frame.index.tolist()}
    assert not remaining & {tuple(key) for key in photo.index[victims].tolist()}


@pytest.mark.longer
def test_points_beyond_repair_are_rejected_however_the_reason_is_worded(points, monkeypatch):
    """What counts is the member that frame.py counts, not the text that people read."""
    photo = points.photos[0]
    xy = photo.xy.copy()
    xy[::7, 0] += np.where(xy[::7, 0] < 320, 9, -9)
    damaged = TargetPoints("dots", points.size, (PhotoPoints(photo.index, xy, photo.area),))
    for text in (Dropped.GROSS.value, "reworded"):
        monkeypatch.setattr(Dropped.GROSS, "_value_", text)
        with pytest.raises(InputError, match="10 % is the limit: indices or points are wrong"):
            ideal_frame(damaged)


@pytest.mark.parametrize("reason", Dropped)
def test_only_points_that_disagree_reject_the_rest(reason):
    assert bool(check_share({reason: 11}, 100)) == (reason is Dropped.GROSS)
    assert not check_share({reason: 10}, 100)


def board_photos(camera, count=5):
    """Exact photos of a 9x6 board, each from another side, with 0.05 pixels of noise."""
    rng = np.random.default_rng(7)
    i, j = np.meshgrid(np.arange(9), np.arange(6))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    photos = []
    for k in range(count):
        turn = rotation(*rng.uniform(-0.5, 0.5, 2), rng.uniform(-0.3, 0.3))
        flat = np.column_stack([index - (4.0, 2.5), np.zeros(54)]) @ turn.T
        points = flat + (*rng.uniform(-2, 2, 2), rng.uniform(7, 9))
        xy = np.stack(camera.project(points), axis=1) + rng.normal(0, 0.05, (54, 2))
        photos.append(PhotoPoints(index, xy, np.zeros(54), {}, f"{k}.png"))
    return TargetPoints("chessboard", camera.size, tuple(photos))


def test_several_photos_share_one_lens():
    camera = Camera.from_dict({"width": 640, "height": 480, "k": [0.02, -0.01],
                               "f_distorted": 330.0, "centre": [327, 233], "p": [0.001, -0.0005]})
    frame = ideal_frame(board_photos(camera))
    assert frame.rms < 0.12
    assert frame.camera.focal == pytest.approx(330, rel=0.02)
    np.testing.assert_allclose(frame.camera.centre, (327, 233), atol=3)
    assert set(frame.photo) == {0, 1, 2, 3, 4} and len(frame.homographies) == 5


def test_points_next_to_and_behind_the_camera_are_outside_a_flat_picture():
    """A floor that runs under an equidistant fisheye, half of it more than 90 degrees off axis."""
    i, j = np.meshgrid(np.arange(9), np.arange(12))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    x, y, z = (i.ravel() - 4.0) / 2, np.ones(108), (j.ravel() - 4.0) / 2
    across = np.hypot(x, y)
    radius = 150 * np.arctan2(across, z) / across
    xy = np.stack([320 + radius * x, 320 + radius * y], axis=1)
    photo = PhotoPoints(index, xy, np.zeros(108), {}, "floor.png")
    frame = ideal_frame(TargetPoints("chessboard", (641, 800), (photo,)), zoom=0.3)
    assert frame.rms < 0.1
    assert frame.index[:, 1].min() > 4 and len(frame.index) > 40
    assert (frame.corrected[:, 1] > 320).all()


def test_random_points_have_no_lens():
    rng = np.random.default_rng(1)
    index = np.stack([np.arange(60) % 10, np.arange(60) // 10], axis=1)
    photo = PhotoPoints(index, rng.uniform((0, 0), (639, 479), (60, 2)), np.zeros(60), {}, "a.png")
    with pytest.raises(InputError, match="no smooth lens explains the points"):
        ideal_frame(TargetPoints("chessboard", (640, 480), (photo,)))


def test_too_few_points():
    index = np.stack([np.arange(9) % 3, np.arange(9) // 3], axis=1)
    photo = PhotoPoints(index, 20.0 * index + 30, np.zeros(9), {}, "a.png")
    with pytest.raises(InputError, match="no photo has 12 whole points on at least 3 rows and 3"):
        ideal_frame(TargetPoints("chessboard", (640, 480), (photo,)))


def test_straightness_of_known_lines():
    index = np.stack([np.arange(30) % 6, np.arange(30) // 6], axis=1)
    flat = index @ np.array([[20.0, 3.0], [-2.0, 25.0]])
    result = straightness(flat, index)
    assert result.lines == 11 and result.max < 1e-12
    bent = flat.copy()
    bent[index[:, 0] == 2] += (0.0, 0.9)       # along the columns' direction almost: moves rows
    result = straightness(bent, index)
    assert 0.5 < result.max < 0.9 and 0.1 < result.rms < result.max
    # Points of different photos are on different lines.
    assert straightness(flat, index, np.arange(30) % 2).lines < 30
    assert straightness(flat[:2], index[:2]).lines == 0


@pytest.mark.longer
@pytest.mark.parametrize("where,pattern,target,zoom,smooth,straight", [
    (photos, "dots/dot_pattern_06.jpg", "dots", "fit", 1.0, 0.65),
    (photos, "chessboard_wide/GOPR003*.jpg", "chessboard:8x6", "fit", 0.4, 0.25),
    (photos, "opencv/left0[1-6].jpg", "chessboard:9x6", "fill", 0.4, 0.2), *(
        pytest.param(full_photos, *case, marks=pytest.mark.regress) for case in (
            ("dots/dot_pattern_06.jpg", "dots", "fit", 2.0, 1.3),
            ("dots/dot_pattern_05.jpg", "dots", "fit", 0.1, 0.05),
            ("chessboard_wide/GOPR003*.jpg", "chessboard:8x6", "fit", 0.8, 0.5),
            ("opencv/left0[1-6].jpg", "chessboard:9x6", "fill", 0.4, 0.2)))])
def test_real_photos(where, pattern, target, zoom, smooth, straight):
    files = where(pattern)
    points = detect_points(((file.name, read_image(file)) for file in files), target)
    frame = ideal_frame(points, zoom=zoom)
    assert frame.rms < smooth
    before = straightness(frame.distorted, frame.index, frame.photo)
    uv = np.stack(frame.camera.corrected(*frame.distorted.T), axis=1)
    after = straightness(uv, frame.index, frame.photo)
    assert after.rms < straight and after.rms < 0.3 * before.rms


@pytest.mark.longer
@pytest.mark.parametrize("where", [
    photos, pytest.param(full_photos, marks=pytest.mark.regress)], ids=["small", "full"])
def test_fisheye_of_180_degrees_needs_a_zoom_in_numbers(where):
    files = where("fisheye/*.jpg")
    points = detect_points(((file.name, read_image(file)) for file in files), "chessboard:6x4")
    with pytest.raises(InputError, match="zoom fit needs a position in the flat picture"):
        ideal_frame(points, zoom="fit")
    frame = ideal_frame(points, zoom=1.0)
    assert frame.rms < 0.5 and len(frame.index) > 140
    # 90 degrees off the axis are at pi/2 focal lengths of an equidistant lens, inside the image.
    assert np.pi / 2 * frame.camera.focal < 320
    uv = np.stack(frame.camera.corrected(*frame.distorted.T), axis=1)
    after = straightness(uv, frame.index, frame.photo).rms
    assert after < 0.1 * straightness(frame.distorted, frame.index, frame.photo).rms
