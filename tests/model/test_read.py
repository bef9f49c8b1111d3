"""Coefficients, size and scale of a camera file, whichever program wrote it."""

import json

import cv2
import numpy as np
import pytest

from camera_files import FISHEYE, MATRIX, ideal_points, opencv_file
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError
from photos import photos

BROWN = [-.09, .006, .0008, -.0011, .004]
RATIONAL = [.31, .02, .0008, -.0011, .001, .66, .08, .003]


def info(path, model, d, **more):
    table = {"width": 640, "height": 480, "distortion_model": model, "K": MATRIX.ravel().tolist(),
             **({} if d is None else {"D": d}), **more}
    path.write_text(json.dumps(table))
    return path


def pixels(read):
    return np.stack(read.distort(*ideal_points()))


@pytest.mark.parametrize("model,k", [("plumb_bob", BROWN), ("plumb_bob", BROWN[:4]),
                                     ("rational_polynomial", RATIONAL), ("equidistant", FISHEYE),
                                     ("opencv", RATIONAL), ("pinhole", BROWN)])
@pytest.mark.parametrize("zeros", [1, 3, 9])
def test_trailing_zeros_change_nothing(tmp_path, model, k, zeros):
    plain, longer = (load_camera_map(info(tmp_path / f"{n}.json", model, k + [0.0] * n), zoom=.5)
                     for n in (0, zeros))
    np.testing.assert_array_equal(pixels(plain), pixels(longer))


@pytest.mark.parametrize("model,straight", [
    ("", True), ("plumb_bob", True), ("rational_polynomial", True), ("none", True),
    ("equidistant", False)])
@pytest.mark.parametrize("d", [[], None, [0.0] * 3, [0.0] * 4, [0.0] * 8])
def test_no_coefficients_are_no_distortion(tmp_path, model, straight, d):
    if not model and d is not None and len(d) == 4:
        model = "plumb_bob"       # K and four D without a model are a fisheye
    read = load_camera_map(info(tmp_path / "c.json", model, d), zoom=.5)
    a, b = ideal_points()
    # OpenCV's fisheye without coefficients is the equidistant projection itself.
    points = np.stack([a, b, np.ones_like(a)], axis=1)[:, None]
    lens = cv2 if straight else cv2.fisheye
    theirs = lens.projectPoints(points, np.zeros(3), np.zeros(3), MATRIX, np.zeros(4))[0]
    np.testing.assert_allclose(pixels(read).T, theirs.reshape(-1, 2), atol=1e-9)
    missing = d is None and model != "none"
    assert any("holds no distortion coefficients" in text for text in read.warnings) == missing


@pytest.mark.parametrize("model,d,message", [
    ("plumb_bob", BROWN + [.1], "plumb_bob has 6 coefficients, 4 or 5 are needed"),
    ("plumb_bob", RATIONAL, "plumb_bob has 8 coefficients, 4 or 5 are needed"),
    ("equidistant", FISHEYE + [.1], "fisheye has 5 coefficients, 4 are needed"),
    ("equidistant", FISHEYE[:3], "fisheye has 3 coefficients, 4 are needed"),
    ("plumb_bob", BROWN[:2], "plumb_bob has 2 coefficients, 4 or 5 are needed"),
    ("opencv", RATIONAL + [.1], "opencv has 9 coefficients, 4 or 5 or 8 or 12 or 14 are needed"),
])
def test_coefficients_without_a_meaning_are_named(tmp_path, model, d, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(info(tmp_path / "c.json", model, d))


def test_files_of_the_cases_are_read():
    path, = photos("cameras/emptyD.yaml")
    np.testing.assert_allclose(load_camera_map(path).distort(1, .5), (331.7 + 415.2, 236.9 + 208))
    path, = photos("cameras/t265_info.yaml")
    assert load_camera_map(path, zoom=.6).model == "fisheye"


@pytest.mark.parametrize("sensor", [(320, 240), (1280, 960), (427, 320), (639, 479)])
def test_a_calibration_of_another_size_is_that_of_the_resized_picture(tmp_path, sensor):
    path = opencv_file(tmp_path / "c.yml", RATIONAL)
    read, own = load_camera_map(path, sensor=sensor), load_camera_map(path)
    # What a picture holds, halved by cv2.resize: where a wide blob's middle comes to lie.
    a, b = .41, -.23
    x, y = own.distort(a, b)
    rows, columns = np.mgrid[:480, :640]
    blob = np.exp(-((columns - x)**2 + (rows - y)**2) / 2 / 12**2)
    small = cv2.resize(blob, sensor, interpolation=cv2.INTER_AREA if sensor[0] < 640
                       else cv2.INTER_LINEAR)
    rows, columns = np.mgrid[:sensor[1], :sensor[0]]
    middle = (small * columns).sum() / small.sum(), (small * rows).sum() / small.sum()
    np.testing.assert_allclose(read.distort(a, b), middle, atol=.01)
    assert read.size == sensor and read.frame.size == sensor
    assert read.notes == (f"the calibration is for 640x480 pixels, the sensor has {sensor[0]}x"
                          f"{sensor[1]}: focal lengths and centre are scaled by "
                          f"{sensor[0] / 640:g}",)


def test_a_large_calibration_is_scaled_to_what_the_hardware_takes(tmp_path):
    path = info(tmp_path / "c.json", "plumb_bob", BROWN, width=6400, height=4800,
                K=(MATRIX * [[10], [10], [1]]).ravel().tolist())
    with pytest.raises(InputError, match="image width is 6400, the limits are 8 and 4096; --"):
        load_camera_map(path)
    assert load_camera_map(path, sensor=(640, 480)).size == (640, 480)


def test_another_aspect_is_rejected(tmp_path):
    path = opencv_file(tmp_path / "c.yml", BROWN)
    with pytest.raises(InputError, match="calibration is for 640x480 pixels, the sensor has 640x360"
                                         ", of another aspect: a frame that is cut needs"):
        load_camera_map(path, sensor=(640, 360))
    assert load_camera_map(path, sensor=(640, 480)).notes == ()


def test_a_centre_far_from_the_middle_is_warned_of(tmp_path):
    path = info(tmp_path / "c.json", "plumb_bob", BROWN, width=1920, height=1080)
    assert any("principal point (318.5, 241.2) is far from the middle of the 1920x1080 image"
               in text for text in load_camera_map(path).warnings)
    assert load_camera_map(info(tmp_path / "d.json", "plumb_bob", BROWN)).warnings == ()


def test_euroc_sensor_file_is_opencvs_model(tmp_path):
    path = tmp_path / "sensor.yaml"
    path.write_text("sensor_type: camera\ncomment: VI-Sensor cam0 (MT9M034)\nT_BS:\n  cols: 4\n"
                    "  rows: 4\n  data: [1.0, 0.0]\nrate_hz: 20\nresolution: [640, 480]\n"
                    "camera_model: pinhole\nintrinsics: [300.0, 300.0, 318.5, 241.25]\n"
                    "distortion_model: radial-tangential\n"
                    f"distortion_coefficients: {BROWN[:4]}\n")
    theirs = load_camera_map(opencv_file(tmp_path / "c.yml", BROWN[:4]))
    np.testing.assert_array_equal(pixels(load_camera_map(path)), pixels(theirs))


def test_omnidirectional_file_of_opencv(tmp_path):
    read = load_camera_map(info(tmp_path / "c.json", "", BROWN[:4], xi=[[1.2]]), zoom=.5)
    a, b = ideal_points()
    k1, k2, p1, p2 = BROWN[:4]
    norm = np.sqrt(a * a + b * b + 1)
    x, y = a / (1 + 1.2 * norm), b / (1 + 1.2 * norm)
    r2 = x * x + y * y
    u = x * (1 + k1 * r2 + k2 * r2 * r2) + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)
    v = y * (1 + k1 * r2 + k2 * r2 * r2) + 2 * p2 * x * y + p1 * (r2 + 2 * y * y)
    np.testing.assert_allclose(pixels(read), (300 * u + 318.5, 300 * v + 241.25), atol=1e-9)


def test_one_of_several_tables_is_chosen(tmp_path):
    tables = {side: json.loads(info(tmp_path / "c.json", "plumb_bob", [k, 0, 0, 0]).read_text())
              for side, k in (("left", -.02), ("right", -.05))}
    (tmp_path / "both.json").write_text(json.dumps(tables))
    with pytest.raises(InputError, match="holds the cameras left, right, one must be chosen"):
        load_camera_map(tmp_path / "both.json")
    x, _ = load_camera_map(tmp_path / "both.json", camera="right").distort(1, 0)
    assert x == pytest.approx(318.5 + 300 * .95)
