"""Where the corrected frame is centred: near the axis of any wide lens, centred or not."""

import json

import numpy as np
import pytest

from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.lens import Camera, rotation
from ncdc_spec.errors import InputError
from photos import photos

SIZE = 1280, 960


def source_of_middle(read):
    width, height = read.frame.size
    return np.array(read.back_map((width - 1) / 2, (height - 1) / 2))


def magnification_on_axis(read):
    """Corrected pixels per distorted pixel on the axis, the mean of both directions."""
    h = 1e-4
    across = np.subtract(read.distort(h, 0.0), read.distort(-h, 0.0))
    down = np.subtract(read.distort(0.0, h), read.distort(0.0, -h))
    area = across[0] * down[1] - across[1] * down[0]
    return read.frame.focal * 2 * h / np.sqrt(area)


def fisheye(path, degrees, centre):
    """An equidistant lens of so many degrees across, its axis ``centre`` off the image's middle."""
    focal = 639.5 / np.radians(degrees / 2)
    matrix = [focal, 0, 639.5 + centre[0], 0, focal, 479.5 + centre[1], 0, 0, 1]
    path.write_text(json.dumps({"width": 1280, "height": 960, "distortion_model": "equidistant",
                                "D": [0.0] * 4, "K": matrix}))
    return path


@pytest.mark.parametrize("name,axis", [("fisheye170", 649.5), ("fisheye170_centred", 639.5),
                                       ("fisheye184", 649.5)])
@pytest.mark.parametrize("zoom", [1.0, .4, 2.0])
def test_the_cases_look_along_the_axis(name, axis, zoom):
    path, = photos(f"cameras/{name}.yaml")
    read = load_camera_map(path, zoom=zoom)
    np.testing.assert_allclose(source_of_middle(read), (axis, 479.5), atol=1e-6)
    assert magnification_on_axis(read) == pytest.approx(zoom, rel=1e-6)


@pytest.mark.parametrize("degrees", [130, 150, 160, 165, 170, 175, 179, 186])
@pytest.mark.parametrize("centre", [(0, 0), (5, 0), (-25, 8), (10, -30)])
def test_wide_lenses_look_near_the_axis_at_a_number(tmp_path, degrees, centre):
    read = load_camera_map(fisheye(tmp_path / "c.json", degrees, centre), zoom=.8)
    # Between the edges, a twentieth of the image's width off its middle is allowed.
    off = np.abs(source_of_middle(read) - (639.5, 479.5))
    assert (off <= np.maximum(np.abs(centre), (64.1, 48.1))).all()
    assert magnification_on_axis(read) == pytest.approx(.8, rel=.03)


@pytest.mark.parametrize("degrees,centre", [(160, (20, 0)), (165, (10, 0)), (150, (0, 40)),
                                            (170, (10, 0)), (175, (0, 20))])
@pytest.mark.parametrize("zoom", ["fit", "fill"])
def test_fit_and_fill_look_along_the_axis_or_say_why_not(tmp_path, degrees, centre, zoom):
    path = fisheye(tmp_path / "c.json", degrees, centre)
    try:
        read = load_camera_map(path, zoom=zoom)
    except InputError as error:
        assert "zoom fit would shrink the middle" in str(error) and degrees > 160
        return
    off = np.abs(source_of_middle(read) - (639.5, 479.5)) / SIZE
    assert (off <= 1 / 6).all()
    if zoom == "fit":       # the farther edge lies on the border, the other one inside
        u, _ = read.frame.pixel(*read.undistort(np.array([0.0, 1279]), np.full(2, 479.5)))
        assert u.min() > -1e-6 and u.max() < 1279 + 1e-6
        assert min(u.min(), 1279 - u.max()) == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("camera", [
    {"camera_model": "omni", "intrinsics": [1.1, 850, 850, 660, 480], "distortion_model": "none"},
    {"camera_model": "eucm", "intrinsics": [.62, 1.1, 430, 430, 655, 470],
     "distortion_model": "none"},
    {"camera_model": "ds", "intrinsics": [-.2, .6, 380, 380, 660, 480],
     "distortion_model": "none"},
    {"camera_model": "pinhole", "intrinsics": [430, 430, 650, 480],
     "distortion_model": "equidistant", "distortion_coeffs": [.01, -.002, 0, 0]}])
def test_other_models_of_wide_lenses_look_near_the_axis(tmp_path, camera):
    (tmp_path / "chain.yaml").write_text(json.dumps({"cam0": {**camera, "resolution": SIZE}}))
    read = load_camera_map(tmp_path / "chain.yaml", zoom=1.0)
    assert np.linalg.norm(source_of_middle(read) - read.distort(0.0, 0.0)) < 64
    assert magnification_on_axis(read) == pytest.approx(1, rel=.03)


def test_an_ordinary_lens_is_centred_between_its_edges(tmp_path):
    path = fisheye(tmp_path / "c.json", 105, (3, -4))
    for zoom in ("fit", .7):
        read = load_camera_map(path, zoom=zoom)
        u, v = read.frame.pixel(*read.undistort(np.array([0, 1279, 639.5, 639.5]),
                                                np.array([479.5, 479.5, 0, 959])))
        assert u[0] + u[1] == pytest.approx(1279) and v[2] + v[3] == pytest.approx(959)


def test_a_part_of_an_image_far_off_the_axis_is_centred_on_itself(tmp_path):
    path = fisheye(tmp_path / "c.json", 60, (-900, 0))
    np.testing.assert_allclose(source_of_middle(load_camera_map(path, zoom=1.0)), (639.5, 479.5),
                               atol=64)


def test_points_of_a_wide_lens_look_near_the_axis():
    lens = Camera.from_dict({"width": 1280, "height": 960, "f_distorted": 431.0, "k": [],
                             "centre": [649.5, 479.5], "f_corrected": 431.0})
    index = np.array([(i, j) for j in range(-6, 7) for i in range(-9, 10)])
    shots = []
    for k, (turn, depth) in enumerate([((0, 0, 0), 1.5), ((.3, .5, 0), 2.0)]):
        rays = np.column_stack([index, np.zeros(len(index))]) @ rotation(*turn).T + (0, 0, depth)
        x, y = lens.project(rays)
        seen = np.isfinite(x) & (x > 2) & (x < 1277) & (y > 2) & (y < 957)
        shots.append(PhotoPoints(index[seen], np.stack([x, y], axis=1)[seen],
                                 np.zeros(int(seen.sum())), name=f"{k}"))
    points = TargetPoints("chessboard", SIZE, tuple(shots))
    camera = ideal_frame(points, zoom=1.0).camera
    np.testing.assert_allclose(camera.back_map(639.5, 479.5), (649.5, 479.5), atol=2)
    assert camera.frame.focal == pytest.approx(431, rel=.01)
