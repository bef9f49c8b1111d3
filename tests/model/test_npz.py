"""Cameras in .npz, as the tutorial of OpenCV keeps them; a map in .npz is no camera."""

import cv2
import numpy as np
import pytest

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.calibration.remap_file import are_remap_files
from ncdc_model.training.source import load_source
from ncdc_spec.errors import InputError

K = np.array([[420.5, 0, 325.5], [0, 418, 236.25], [0, 0, 1]])
D = np.array([[-.25, .12, .0008, -.0011, -.03]])


def tutorial(path, **more):
    """B.npz of the tutorial: np.savez with the poses, lists of arrays, among them."""
    poses = np.empty(2, object)
    poses[:] = [np.zeros((3, 1)), np.ones((3, 1))]
    np.savez(path, mtx=K, dist=D, rvecs=poses, tvecs=np.zeros((2, 3, 1)), **more)
    return path


def test_the_file_of_the_tutorial_gives_the_pixels_of_opencv(tmp_path):
    path = tutorial(tmp_path / "B.npz")
    assert are_remap_files(path) == ([path], False)
    a, b = (value / 2 for value in ideal_points())
    theirs = cv2.projectPoints(np.stack([a, b, np.ones_like(a)], axis=1), np.zeros(3), np.zeros(3),
                               K, D)[0].reshape(-1, 2)
    with pytest.raises(InputError, match="B.npz: the file does not say the size of the image; "
                                         "--sensor-size WxH gives it"):
        load_source(path)
    read = load_camera_map(path, sensor=(640, 480))
    np.testing.assert_allclose(np.stack(read.distort(a, b), axis=1), theirs, atol=1e-9)
    assert load_source(path, sensor=(640, 480)).geometry.distorted == (640, 480)
    sized = tutorial(tmp_path / "C.npz", img_size=(640, 480), error=np.float64(.03))
    assert load_camera_map(sized).size == (640, 480)


def test_a_map_next_to_a_camera_is_a_map(tmp_path):
    maps = cv2.initUndistortRectifyMap(K, D, None, K, (640, 480), cv2.CV_32FC1)
    path = tutorial(tmp_path / "both.npz", mapx=maps[0], mapy=maps[1])
    assert are_remap_files(path) == ([path], True)
    for size in (64, 480):
        np.savez(tmp_path / "left.npz", mtx=K, dist=D, left_x=maps[0][:size], left_y=maps[1][:size])
        assert are_remap_files(tmp_path / "left.npz")[1]


def test_a_pair_of_cameras(tmp_path):
    np.savez(tmp_path / "pair.npz", mtx_left=K, dist_left=D, mtx_right=2 * K - np.diag([0, 0, 1]),
             dist_right=D)
    with pytest.raises(InputError, match="holds the cameras left, right, one must be chosen"):
        load_camera_map(tmp_path / "pair.npz", sensor=(640, 480))
    right = load_camera_map(tmp_path / "pair.npz", sensor=(1280, 960), camera="right")
    assert right.distort(0.0, 0.0)[0] == 651
