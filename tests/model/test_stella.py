"""Settings of stella_vslam and OpenVSLAM: nested names and names with a point, three models."""

import cv2
import numpy as np
import pytest

from camera_files import FISHEYE, MATRIX, ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError
from photos import photos

CAMERA = {"name": "x", "setup": "monocular", "fx": 300, "fy": 300, "cx": 318.5, "cy": 241.25,
          "fps": 30, "cols": 640, "rows": 480, "color_order": "Gray"}
BROWN = dict(zip(("k1", "k2", "p1", "p2", "k3"), (-.09, .006, .0008, -.0011, .004)))


def write(path, camera, more="", nested=True):
    lines = [f"{'  ' if nested else 'Camera.'}{name}: {value}\n" for name, value in camera.items()]
    path.write_text("Camera:\n" * nested + "".join(lines) + "Mapping:\n"
                    "  baseline_dist_thr_ratio: 0.02\n" + more)
    return path


@pytest.mark.parametrize("nested", [True, False])
@pytest.mark.parametrize("model,k,lens", [
    ("perspective", BROWN, cv2),
    ("fisheye", dict(zip(("k1", "k2", "k3", "k4"), FISHEYE)), cv2.fisheye)])
def test_models_give_the_pixels_of_opencv(tmp_path, model, k, lens, nested):
    read = load_camera_map(write(tmp_path / "c.yaml", {**CAMERA, "model": model, **k},
                                 nested=nested))
    a, b = ideal_points()
    theirs = lens.projectPoints(np.stack([a, b, np.ones_like(a)], axis=1)[:, None], np.zeros(3),
                                np.zeros(3), MATRIX, np.array(list(k.values())))[0]
    np.testing.assert_allclose(np.stack(read.distort(a, b), axis=1), theirs.reshape(-1, 2),
                               atol=1e-9)
    assert read.size == (640, 480)


@pytest.mark.parametrize("k", [-.2, .15])
def test_the_division_model_is_undone(tmp_path, k):
    read = load_camera_map(write(tmp_path / "c.yaml", {**CAMERA, "model": "radial_division",
                                                       "distortion": k}))
    a, b = ideal_points()
    x, y = (np.array(read.distort(a, b)) - [[318.5], [241.25]]) / 300
    scale = 1 + k * (x * x + y * y)
    np.testing.assert_allclose((x / scale, y / scale), (a, b), atol=1e-12)


def test_the_file_of_the_case():
    read = load_camera_map(*photos("cameras/openvslam.yaml"))
    assert read.model == "stella_vslam fisheye" and read.size == (1600, 1200)
    angle = np.arctan(.5)
    np.testing.assert_allclose(read.distort(.5, 0.0),
                               (806.1 + 731.25 * angle * (1 + .03 * angle**2), 588.7))


@pytest.mark.parametrize("change,more,message", [
    ({"model": "equirectangular"}, "", "the model is equirectangular of stella_vslam, one of"),
    ({"model": "perspective", "k1": .1}, "", "lacks the value k2"),
    ({"model": "perspective", **BROWN, "k4": .1}, "", "entry k4 may be distortion"),
    ({"model": "perspective", **BROWN, "k1": "yes"}, "", "holds true or false"),
    ({"model": "perspective", **BROWN}, "StereoRectifier:\n  K_left: [1]\n",
     "with a StereoRectifier, whose Camera is that of rectified pictures"),
])
def test_bad_values_are_named(tmp_path, change, more, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(write(tmp_path / "c.yaml", {**CAMERA, **change}, more))
