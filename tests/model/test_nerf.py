"""transforms.json: its pixels count from the corner, as COLMAP's, from which they come."""

import json

import numpy as np
import pycolmap
import pytest

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

OWN = {"w": 640, "h": 480, "fl_x": 300.0, "fl_y": 303.0, "cx": 318.5, "cy": 241.25}
K4 = [-.09, .006, .0008, -.0011]


def write(path, **table):
    path.write_text(json.dumps({**table, "frames": table.get("frames", [
        {"file_path": "images/1.png", "transform_matrix": np.eye(4).tolist()}])}))
    return path


def colmap(model, k):
    a, b = ideal_points()
    camera = pycolmap.Camera(camera_id=1, model=model, width=640, height=480,
                             params=[300.0, 303.0, 318.5, 241.25, *k])
    return np.array(camera.img_from_cam(np.stack([a, b, np.ones_like(a)], axis=1)))


@pytest.mark.parametrize("model,names,k", [
    ("OPENCV", ("k1", "k2", "p1", "p2"), K4),
    ("OPENCV_FISHEYE", ("k1", "k2", "k3", "k4"), [.02, -.006, .002, -.0005])])
def test_models_give_the_pixels_of_colmap(tmp_path, model, names, k):
    read = load_camera_map(write(tmp_path / "transforms.json", camera_model=model, **OWN,
                                 **dict(zip(names, k))))
    pixels = np.stack(read.distort(*ideal_points()), axis=1)
    np.testing.assert_allclose(pixels, colmap(model, k) - .5, atol=1e-6)
    assert read.size == (640, 480)


def test_further_radial_terms_are_those_of_nerfstudio(tmp_path):
    k = dict(k1=-.09, k2=.006, k3=.004, k4=-.002)
    read = load_camera_map(write(tmp_path / "transforms.json", **OWN, **k))
    a, b = ideal_points()
    r = a * a + b * b
    d = 1.0 + r * (k["k1"] + r * (k["k2"] + r * (k["k3"] + r * k["k4"])))
    np.testing.assert_allclose(read.distort(a, b), (300 * a * d + 318, 303 * b * d + 240.75),
                               atol=1e-9)


def test_angle_instead_of_a_focal_length(tmp_path):
    read = load_camera_map(write(tmp_path / "t.json", w=640, h=480, camera_angle_x=np.pi / 2))
    np.testing.assert_allclose(read.distort(np.array([-1, 1]), np.zeros(2))[0], [-.5, 639.5])


def test_cameras_of_the_frames(tmp_path):
    frames = [{"file_path": f"{k}.png", "transform_matrix": [], **OWN, "fl_x": 300.0 + k}
              for k in (0, 50)]
    path = write(tmp_path / "t.json", frames=frames)
    with pytest.raises(InputError, match="frames 0.png, 50.png, one must be chosen"):
        load_camera_map(path)
    assert load_camera_map(path, camera="50.png").distort(1, 0)[0] == 668
    mixed = write(tmp_path / "m.json", **OWN, frames=[
        {**frames[0], "fl_x": 300.0, "camera_model": "OPENCV_FISHEYE"}, {"file_path": "b.png"}])
    with pytest.raises(InputError, match="frames 0.png, b.png, one must be chosen"):
        load_camera_map(mixed)
    assert load_camera_map(mixed, camera="0.png", zoom=.5).model == "NeRF OPENCV_FISHEYE"
    assert load_camera_map(mixed, camera="b.png").model == "NeRF OPENCV"
    same = write(tmp_path / "s.json", frames=[{**frame, "fl_x": 300.0} for frame in frames])
    assert load_camera_map(same).distort(1, 0)[0] == 618


def test_size_that_the_file_does_not_say(tmp_path):
    path = write(tmp_path / "t.json", **{name: OWN[name] for name in ("fl_x", "cx", "cy")})
    with pytest.raises(InputError, match="does not say the size of the image; --sensor-size"):
        load_camera_map(path)
    assert load_camera_map(path, sensor=(640, 480)).distort(1, 0)[0] == 618


@pytest.mark.parametrize("change,message", [
    ({"camera_model": "EQUIRECTANGULAR"}, "camera model is EQUIRECTANGULAR, OPENCV or"),
    ({"camera_model": "OPENCV_FISHEYE", "p1": .1}, "p1 and p2 are given, which the model OPENCV_F"),
    ({"w": None}, "a value of the wrong kind"), ({"k1": "x"}, "a value of the wrong kind"),
])
def test_bad_values_are_named(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(write(tmp_path / "t.json", **{**OWN, **change}))
