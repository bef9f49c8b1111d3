"""Camera files of OpenCV, ROS, BoofCV and ours: same numbers, same map, whatever the file."""

import json

import cv2
import numpy as np
import pytest

from camera_files import FISHEYE, MATRIX, ideal_points, opencv_file
from ncdc_model.calibration.camera_file import load_camera_map, training_grid
from ncdc_model.golden.valid import valid_mask
from ncdc_model.lens import Camera, TiltedSensor
from ncdc_spec.errors import InputError
from photos import photos

RATIONAL = [.31, .02, .0008, -.0011, .001, .66, .08, .003]
FULL = RATIONAL + [.0012, .0002, -.0007, .0001, .011, -.008]
def ros_text(model, coefficients):
    numbers = ", ".join(map(str, MATRIX.ravel()))
    block = "".join(f"  - {c}\n" for c in coefficients)
    return (f"image_width: 640\nimage_height: 480\ncamera_name: cam\ncamera_matrix:\n  rows: 3\n"
            f"  cols: 3\n  data: [{numbers}]\ndistortion_model: {model}\n"
            f"distortion_coefficients:\n  rows: 1\n  cols: {len(coefficients)}\n  data:\n{block}")


def our_fisheye():
    """The fisheye by our own formulas, framed at 200 pixels per unit of the ideal plane."""
    return Camera.from_dict({"width": 640, "height": 480, "f_distorted": 300.0, "k": FISHEYE,
                             "centre": [318.5, 241.25], "f_corrected": 200.0})


@pytest.mark.parametrize("count", [4, 5, 8, 12, 14])
def test_perspective_model_equals_its_published_formulas(tmp_path, count):
    c = np.zeros(14)
    c[:count] = FULL[:count] if count >= 8 else [-.09, .006, .0008, -.0011, .004][:count]
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty = c
    read = load_camera_map(opencv_file(tmp_path / "c.yml", c[:count]))
    a, b = ideal_points()
    q = a * a + b * b
    radial = (1 + k1 * q + k2 * q**2 + k3 * q**3) / (1 + k4 * q + k5 * q**2 + k6 * q**3)
    x = a * radial + 2 * p1 * a * b + p2 * (q + 2 * a * a) + s1 * q + s2 * q * q
    y = b * radial + p1 * (q + 2 * b * b) + 2 * p2 * a * b + s3 * q + s4 * q * q
    x, y = TiltedSensor((tx, ty)).distort(x, y)
    np.testing.assert_allclose(read.distort(a, b), (300 * x + 318.5, 300 * y + 241.25), atol=1e-6)
    assert str(count) in read.model and read.size == (640, 480)


def test_fisheye_model_equals_our_own_formula(tmp_path):
    read = load_camera_map(opencv_file(tmp_path / "c.yml", FISHEYE, distortion_model="fisheye"))
    a, b = ideal_points()
    np.testing.assert_allclose(read.distort(a, b), our_fisheye().distort(a, b),
                               atol=1e-6)


def test_every_container_gives_the_same_map(tmp_path):
    a, b = ideal_points()
    reference = np.array(load_camera_map(opencv_file(tmp_path / "c.yml", RATIONAL)).distort(a, b))
    files = [opencv_file(tmp_path / f"c.{kind}", RATIONAL) for kind in ("xml", "json")]
    files.append(tmp_path / "ros.yaml")
    files[-1].write_text(ros_text("rational_polynomial", RATIONAL))
    files.append(tmp_path / "info.yaml")
    files[-1].write_text(json.dumps({
        "width": 640, "height": 480, "distortion_model": "rational_polynomial", "D": RATIONAL,
        "K": MATRIX.ravel().tolist()}))
    for file in files:
        np.testing.assert_allclose(load_camera_map(file).distort(a, b), reference, atol=1e-9,
                                   err_msg=file.name)


def test_fisheye_is_recognised_in_three_ways(tmp_path):
    ros = tmp_path / "ros.yaml"
    ros.write_text(ros_text("equidistant", FISHEYE))
    bare = tmp_path / "bare.yml"
    storage = cv2.FileStorage(str(bare), cv2.FILE_STORAGE_WRITE)
    for name, value in (("image_width", 640), ("image_height", 480), ("K", MATRIX),
                        ("D", np.array(FISHEYE))):
        storage.write(name, value)
    storage.release()
    flagged = opencv_file(tmp_path / "flag.yml", FISHEYE, fisheye_model=1)
    for file in (ros, bare, flagged):
        assert load_camera_map(file).model == "fisheye"
    assert "perspective" in load_camera_map(opencv_file(tmp_path / "plain.yml", FISHEYE)).model


def test_zoom_fit_shows_the_full_width_and_fill_leaves_nothing_empty(tmp_path):
    path = opencv_file(tmp_path / "c.yml", RATIONAL)
    fit, fill = (load_camera_map(path, zoom=zoom) for zoom in (None, "fill"))
    x, _ = fit.back_map(np.array([0.0, 639.0]), np.full(2, 239.5))
    np.testing.assert_allclose(x, [0, 639], atol=.5)
    assert valid_mask(fit.back_map, fit.geometry()).mean() < 1
    assert valid_mask(fill.back_map, fill.geometry()).all()
    half = load_camera_map(path, size=(320, 240), zoom=.5)
    u, v = half.frame.pixel(*np.array([[0, 1e-4], [0, 0]]))
    x, y = half.back_map(u, v)
    assert half.geometry().corrected == (320, 240)
    assert (u[1] - u[0]) / (x[1] - x[0]) == pytest.approx(.5, rel=.05)


def test_back_map_ends_where_the_model_folds(tmp_path):
    read = load_camera_map(opencv_file(tmp_path / "c.yml", [-.3, 0, 0, 0]), zoom=.3)
    x, y = read.distort(np.array([1.0, 1.1, 5.0]), np.zeros(3))    # r - .3 r^3 turns at 1.054
    assert np.isfinite(x[0]) and np.isnan(x[1:]).all()
    mask = valid_mask(read.back_map, read.geometry())
    u, v, _, _ = training_grid(read.back_map, read.geometry())
    assert mask[v.round().astype(int), u.round().astype(int)].all()


def test_our_camera_file_keeps_its_frame_unless_asked(tmp_path):
    camera = our_fisheye()
    camera.save(tmp_path / "c.toml")
    same, fitted = (load_camera_map(tmp_path / "c.toml", zoom=zoom) for zoom in (None, "fit"))
    assert same.frame == camera.frame and fitted.frame == camera.framed().frame != camera.frame
    u, v = np.array([100.0, 320, 600]), np.array([50.0, 240, 470])
    np.testing.assert_array_equal(same.back_map(u, v), camera.back_map(u, v))


def test_training_grid_holds_exact_pairs_and_the_border(tmp_path):
    camera_map = load_camera_map(opencv_file(tmp_path / "c.yml", RATIONAL))
    u, v, x, y = training_grid(camera_map.back_map, camera_map.geometry())
    np.testing.assert_array_equal(camera_map.back_map(u, v), (x, y))
    mask = valid_mask(camera_map.back_map, camera_map.geometry())
    assert 1500 < len(u) < 61 * 41 + 240
    far = cv2.distanceTransform(np.pad(mask, 1).astype(np.uint8), cv2.DIST_C, 3)[1:-1, 1:-1]
    assert (far[v.round().astype(int), u.round().astype(int)] == 1).sum() > 200


def test_real_opencv_file():
    path, = photos("opencv/left_intrinsics.yml")
    read = load_camera_map(path)
    k1, k2, p1, p2, k3 = (-2.6637260909660682e-01, -3.8588898922304653e-02,
                          1.7831947042852964e-03, -2.8122100441115472e-04, 2.3839153080878486e-01)
    a, b = ideal_points()
    a, b = a / 2, b / 2
    q = a * a + b * b
    radial = 1 + k1 * q + k2 * q**2 + k3 * q**3
    x = a * radial + 2 * p1 * a * b + p2 * (q + 2 * a * a)
    y = b * radial + p1 * (q + 2 * b * b) + 2 * p2 * a * b
    focal = 5.3591573396163199e+02
    np.testing.assert_allclose(read.distort(a, b), (focal * x + 3.4228315473308373e+02,
                                                    focal * y + 2.3557082909788173e+02), atol=1e-6)


def test_real_omnidirectional_file_needs_a_number_as_zoom():
    path, = photos("fisheye/fisheye.yaml")
    with pytest.raises(InputError, match="sees at 90 degrees or more"):
        load_camera_map(path)
    read = load_camera_map(path, zoom=.6)
    assert read.size == (640, 720) and read.model == "omnidirectional_universal"
    # The axis hits the principal point; 45 degrees to the right by the model's own equations.
    x, y = read.distort(np.array([0.0, 1.0]), np.zeros(2))
    flat = np.sqrt(.5) / (np.sqrt(.5) + 1.1331346732794045)
    bent = flat * (1 - 0.24972089525362837 * flat**2 + 0.009672326567075125 * flat**4)
    np.testing.assert_allclose(x, 319.17879590584187 + 398.77492706579216 * np.array([0, bent]))
    np.testing.assert_allclose(y, 319.71743712432686)


@pytest.mark.parametrize("text,message", [
    (ros_text("plumb_bob", [0] * 5).replace("image_height", "h"),
     "lacks the value image_height or image_Height or imageHeight or height"),
    (ros_text("plumb_bob", [0] * 5).replace("camera_matrix", "other"), "lacks the value camera_m"),
    (ros_text("plumb_bob", [0] * 5).replace("640", "9000"), "width is 9000, the limits are 8"),
    (ros_text("plumb_bob", [0] * 5).replace("640", "wide"), "a value of the wrong kind: .*wide"),
    (ros_text("plumb_bob", [.1] * 7), "plumb_bob has 7 coefficients, 4 or 5 are needed"),
    (ros_text("equidistant", [.1] * 5), "model fisheye has 5 coefficients, 4 are needed"),
    (ros_text("double_sphere", [0] * 5), "distortion model is 'double_sphere', one of plumb_bob"),
    (ros_text("plumb_bob", [0, 0, ".nan", 0, 0]), "coefficients holds a number that is not finite"),
    (ros_text("plumb_bob", [0] * 5).replace("300.0", "-3.0"), "are -3 and -3, they must be"),
    (ros_text("plumb_bob", [0] * 5).replace(", 1.0]", "]"), "matrix has 8 numbers, 9 are needed"),
    ("just words", "holds no names and values"),
    ("a: [1, 2", "is no camera file"),
    ("%YAML:1.0\n---\na: [1, 2", "is no camera file"),
    ("<?xml version='1.0'?><oops", "is no camera file"),
])
def test_bad_files_are_named(tmp_path, text, message):
    path = tmp_path / "camera.yaml"
    path.write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        load_camera_map(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_bytes_that_are_no_text_and_absent_files(tmp_path):
    (tmp_path / "c.yaml").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(InputError, match="is no camera file"):
        load_camera_map(tmp_path / "c.yaml")
    with pytest.raises(InputError, match="cannot read .*none.yaml: No such file"):
        load_camera_map(tmp_path / "none.yaml")


def test_a_frame_almost_without_source_is_rejected(tmp_path):
    read = load_camera_map(opencv_file(tmp_path / "c.yml", [-.3, 0, 0, 0]), zoom=.05)
    with pytest.raises(InputError, match="of the corrected frame has a source, 5 % is the limit"):
        training_grid(read.back_map, read.geometry())
