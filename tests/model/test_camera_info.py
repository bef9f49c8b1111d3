"""Rectification, projection, binning and region of interest: the maps of OpenCV."""

import json

import cv2
import numpy as np
import pytest

from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.lens import rotation
from ncdc_spec.errors import InputError
from photos import photos

SIZE = 640, 480
K = np.array([[420.0, 0, 325.5], [0, 418.0, 236.25], [0, 0, 1]])
P = np.array([[390.0, 0, 318.0, -40.5], [0, 395.0, 244.0, 0], [0, 0, 1, 0]])
R = rotation(.03, -.05, .02)
D = {"plumb_bob": [-.25, .12, .0008, -.0011, -.03], "equidistant": [.02, -.006, .002, -.0005]}


def camera_info(path, model="plumb_bob", **more):
    table = {"width": SIZE[0], "height": SIZE[1], "distortion_model": model, "D": D[model],
             "K": K.ravel().tolist(), "R": R.ravel().tolist(), "P": P.ravel().tolist(), **more}
    path.write_text(json.dumps(table))
    return path


def opencv_map(model, matrix, turn, new, size):
    make = cv2.fisheye if model == "equidistant" else cv2
    return make.initUndistortRectifyMap(matrix, np.array(D[model]), turn, new[:, :3], size,
                                        cv2.CV_32FC1)


def assert_same(read, theirs):
    width, height = read.frame.size
    u, v = np.meshgrid(np.arange(width), np.arange(height))
    for ours, table in zip(read.back_map(u, v), theirs):
        assert np.isfinite(ours).mean() > .97
        np.testing.assert_allclose(ours[np.isfinite(ours)], table[np.isfinite(ours)], atol=1e-4)


@pytest.mark.parametrize("model", D)
def test_default_frame_is_the_map_of_opencv(tmp_path, model):
    read = load_camera_map(camera_info(tmp_path / "info.yaml", model))
    assert_same(read, opencv_map(model, K, R, P, SIZE))
    assert any("turned by 3.55 degrees" in note for note in read.notes)
    assert any("focal lengths 390.00 and 395.00, centre (318.00, 244.00)" in note
               for note in read.notes)


def test_undistort_is_the_inverse_of_the_turned_view(tmp_path):
    read = load_camera_map(camera_info(tmp_path / "info.yaml"))
    u, v = np.meshgrid(np.linspace(20, 620, 7), np.linspace(20, 460, 6))
    np.testing.assert_allclose(read.frame.pixel(*read.undistort(*read.back_map(u, v))), (u, v),
                               atol=1e-6)


@pytest.mark.parametrize("options", [{"zoom": .8}, {"size": (320, 240)}, {"zoom": "fill"}])
def test_with_zoom_or_size_the_rotation_still_turns_the_view(tmp_path, options):
    read = load_camera_map(camera_info(tmp_path / "info.yaml"), **options)
    frame = read.frame
    assert frame.aspect == 1 and frame.focal != P[0, 0]
    assert_same(read, opencv_map("plumb_bob", K, R, frame.matrix, frame.size))


def test_stereo_file_of_the_case_is_the_map_of_opencv():
    path, = photos("cameras/stereo_right.yaml")
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    values = [storage.getNode(name).mat() for name in (
        "camera_matrix", "distortion_coefficients", "rectification_matrix", "projection_matrix")]
    theirs = cv2.initUndistortRectifyMap(*values[:3], values[3][:, :3], (752, 480), cv2.CV_32FC1)
    assert_same(load_camera_map(path), theirs)


@pytest.mark.parametrize("names", [("M", "D", ""), ("camera_matrix", "dist_coeffs", "_")])
@pytest.mark.parametrize("camera", ["1", "2", None])
def test_one_camera_of_a_stereo_file_of_opencv(tmp_path, names, camera):
    path = tmp_path / "stereo.yml"
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    matrix, dist, joint = names
    for k, offset in ((1, 0), (2, 15)):
        storage.write(f"{matrix}{joint}{k}", K + [[0, 0, offset], [0, 0, 0], [0, 0, 0]])
        storage.write(f"{dist}{joint}{k}", np.array([D["plumb_bob"]]))
        storage.write(f"R{joint}{k}", R if k == 2 else R.T)
        storage.write(f"P{joint}{k}", P)
    storage.write("R", rotation(.3, 0, 0))       # from the first camera to the second
    storage.write("T", np.array([[-.12, 0, 0]]).T)
    storage.release()
    if camera is None:
        with pytest.raises(InputError, match="holds the cameras 1, 2, one must be chosen"):
            load_camera_map(path, sensor=SIZE)
        return
    with pytest.raises(InputError, match="does not say the size of the image; --sensor-size"):
        load_camera_map(path, camera=camera)
    matrix = K + [[0, 0, 15 * (camera == "2")], [0, 0, 0], [0, 0, 0]]
    assert_same(load_camera_map(path, camera=camera, sensor=SIZE),
                opencv_map("plumb_bob", matrix, R if camera == "2" else R.T, P, SIZE))


def test_what_is_not_set_changes_nothing(tmp_path):
    plain = load_camera_map(camera_info(tmp_path / "a.yaml", R=None, P=None))
    zeros = load_camera_map(camera_info(tmp_path / "b.yaml", R=[0.0] * 9, P=[0.0] * 12,
                                        binning_x=0, binning_y=0, roi=dict.fromkeys(
                                            ("x_offset", "y_offset", "width", "height"), 0)))
    assert plain.frame == zeros.frame and plain.notes == zeros.notes == ()
    whole = camera_info(tmp_path / "c.yaml", R=None, P=None, binning_x=1, roi=dict(
        x_offset=0, y_offset=0, width=640, height=480, do_rectify=False))
    assert load_camera_map(whole).frame == plain.frame


@pytest.mark.parametrize("binning,roi", [
    ((2, 2), (0, 0, 0, 0)), ((4, 3), (0, 0, 0, 0)), ((1, 1), (80, 40, 480, 400)),
    ((2, 2), (80, 40, 480, 401))])
def test_binning_and_roi_as_image_geometry_takes_them(tmp_path, binning, roi):
    x, y, width, height = roi
    path = camera_info(tmp_path / "info.yaml", binning_x=binning[0], binning_y=binning[1],
                       roi=dict(x_offset=x, y_offset=y, width=width, height=height,
                                do_rectify=bool(width)))
    # Both matrices less the offset, then divided: fx, cx by binning_x, fy, cy by binning_y.
    to = np.array([[1 / binning[0], 0, -x / binning[0]], [0, 1 / binning[1], -y / binning[1]],
                   [0, 0, 1]])
    size = (width or 640) // binning[0], (height or 480) // binning[1]
    read = load_camera_map(path)
    assert read.size == read.frame.size == size
    assert_same(read, opencv_map("plumb_bob", to @ K, R, to @ P[:, :3], size))
    assert f"the frames have {size[0]}x{size[1]} pixels" in read.notes[1]


def test_a_matrix_of_binned_frames_is_not_divided_again():
    path, = photos("cameras/ros1_echo_binning4.yaml")
    with pytest.raises(InputError, match="binning_x and binning_y are 4 and 4, but the camera"):
        load_camera_map(path)


@pytest.mark.parametrize("x,y", [(2, 2), (3, 1), (1, 2), (8, 8)])
def test_a_matrix_of_binned_frames_is_found_on_each_axis(tmp_path, x, y):
    to = np.diag([1 / x, 1 / y, 1])
    path = camera_info(tmp_path / "info.yaml", binning_x=x, binning_y=y,
                       K=(to @ K).ravel().tolist(), P=None, R=None)
    with pytest.raises(InputError, match=f"binning_x and binning_y are {x} and {y}, but the cam"):
        load_camera_map(path)


def box(x, y, width, height, **more):
    return {"roi": {"x_offset": x, "y_offset": y, "width": width, "height": height, **more}}


@pytest.mark.parametrize("change,message", [
    ({"binning_x": -2}, "binning_x is -2, a whole number from 0 on is needed"),
    ({"binning_y": 1.5}, "binning_y is 1.5, a whole number from 0 on is needed"),
    ({"binning_x": 200}, "image width is 3, the limits are 8 and 4096"),
    (box(200, 0, 480, 480), "roi spans pixels 200 to 680 in x, the image has 640"),
    (box(0, 0, 640, 490), "roi spans pixels 0 to 490 in y, the image has 480"),
    (box(-1, 0, 64, 48), "roi x_offset is -1, a whole number from 0 on is needed"),
    (box(0, 0, 64, 0), "roi spans pixels 0 to 0 in y"),
    (box(0, 0, 64, 48, do_rectify="maybe"), "roi do_rectify is 'maybe', true or false"),
    ({"roi": [1, 2]}, r"roi is \[1, 2\], names and values are needed"),
    ({"R": [1.0] * 9}, "rectification matrix R is no rotation"),
    ({"R": [1.0] * 8}, "rectification matrix has 8 numbers, 9 are needed"),
    ({"R": [1, 0, 0, 0, 1, 0, 0, 0, -1]}, "rectification matrix R is no rotation"),
    ({"P": [1.0] * 11}, "projection matrix has 11 numbers, 9 or 12 are needed"),
    ({"P": [-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0]}, "projection matrix P is .*fx, 0, cx"),
    ({"K": K.T.ravel().tolist()}, r"camera matrix is .*\[\[fx, 0, cx\]"),
    ({"K": [420, 2, 320, 0, 420, 240, 0, 0, 1]}, "camera matrix has the skew 2"),
])
def test_nonsense_is_named(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(camera_info(tmp_path / "info.yaml", **change))


def test_a_rotation_that_may_be_another_is_named(tmp_path):
    path = tmp_path / "c.yaml"
    path.write_text(json.dumps({"width": 640, "height": 480, "D": D["plumb_bob"],
                                "K": K.ravel().tolist(), "R": R.ravel().tolist()}))
    with pytest.raises(InputError, match="R is given without P: named rectification_matrix it"):
        load_camera_map(path)
