"""OpenSfM: lengths are parts of the larger side, from the middle of the picture."""

import json

import cv2
import numpy as np
import pytest

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

ONE, TWO = {"focal": .8}, {"focal_x": .8, "focal_y": .81, "c_x": .01, "c_y": -.02}
K1, K2, K3, K4, P1, P2 = -.09, .006, .004, -.0005, .0008, -.0011


def camera(model, focal, **more):
    return {"projection_type": model, "width": 640, "height": 480, **focal, **more}


def write(path, table):
    path.write_text(json.dumps(table))
    return path


@pytest.mark.parametrize("model,focal,names,lens,k", [
    ("perspective", ONE, {"k1": K1, "k2": K2}, cv2, [K1, K2, 0, 0]),
    ("simple_radial", TWO, {"k1": K1}, cv2, [K1, 0, 0, 0]),
    ("radial", TWO, {"k1": K1, "k2": K2}, cv2, [K1, K2, 0, 0]),
    ("brown", TWO, {"k1": K1, "k2": K2, "k3": K3, "p1": P1, "p2": P2}, cv2, [K1, K2, P1, P2, K3]),
    ("fisheye", ONE, {"k1": K1, "k2": K2}, cv2.fisheye, [K1, K2, 0, 0]),
    ("fisheye_opencv", TWO, {"k1": K1, "k2": K2, "k3": K3, "k4": K4}, cv2.fisheye,
     [K1, K2, K3, K4])])
def test_models_give_the_pixels_of_opencv(tmp_path, model, focal, names, lens, k):
    read = load_camera_map(write(tmp_path / "c.json", {"v2 a": camera(model, focal, **names)}))
    # The page on geometry of OpenSfM: pixel = max(w, h) * coordinate + (side - 1) / 2.
    fx, fy = 640 * focal.get("focal_x", .8), 640 * focal.get("focal_y", .8)
    matrix = np.array([[fx, 0, 640 * focal.get("c_x", 0) + 319.5],
                       [0, fy, 640 * focal.get("c_y", 0) + 239.5], [0, 0, 1]])
    a, b = (value / 2 for value in ideal_points())
    theirs = lens.projectPoints(np.stack([a, b, np.ones_like(a)], axis=1)[:, None], np.zeros(3),
                                np.zeros(3), matrix, np.array(k, float))[0].reshape(-1, 2)
    np.testing.assert_allclose(np.stack(read.distort(a, b), axis=1), theirs, atol=1e-9)
    assert read.size == (640, 480) and not read.warnings


def test_cameras_of_reconstructions(tmp_path):
    cameras = {f"v2 {k}": camera("perspective", {"focal": .8 + k}, k1=0.0, k2=0.0) for k in (0, 1)}
    part = {"cameras": cameras, "shots": {"a.jpg": {"rotation": [1, 2, 3]}}, "points": {}}
    path = write(tmp_path / "reconstruction.json", [part])
    with pytest.raises(InputError, match="holds the cameras v2 0, v2 1, one must be chosen"):
        load_camera_map(path)
    assert load_camera_map(path, camera="v2 1").distort(1, 0)[0] == 319.5 + 640 * 1.8
    path = write(tmp_path / "reconstruction.json", [part, part])
    assert load_camera_map(path, camera="1 v2 0").distort(1, 0)[0] == 319.5 + 640 * .8


@pytest.mark.parametrize("entry,message", [
    (camera("fisheye62", TWO, k1=.1), "of OpenSfM, whose camera a has the model fisheye62; one of"),
    (camera("spherical", {}), "has the model spherical; one of perspective"),
    (camera("perspective", ONE, k1=K1, k3=.1), "entry k3 may be distortion"),
    (camera("perspective", ONE, k1=False), "coefficients holds true or false, numbers are needed"),
    (camera("brown", ONE), "lacks the value focal_x"),
])
def test_bad_values_are_named(tmp_path, entry, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(write(tmp_path / "c.json", {"a": entry}))
