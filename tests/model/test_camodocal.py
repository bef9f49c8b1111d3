"""Cameras of camodocal (VINS): each model by the equations of its source and by OpenCV."""

import cv2
import numpy as np
import pytest

from camera_files import FISHEYE, ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

K = np.array([[300.0, 0, 318.5], [0, 303.0, 241.25], [0, 0, 1]])
K4 = [-.09, .006, .0008, -.0011]


def camera(path, model, distortion, projection, more=""):
    def part(title, names):
        return f"{title}:\n" + "".join(f"   {n}: {v}\n" for n, v in names.items()) if names else ""
    path.write_text(f"%YAML:1.0\n---\nmodel_type: {model}\ncamera_name: camera\nimage_width: 640\n"
                    f"image_height: 480\n{more}{part('distortion_parameters', distortion)}"
                    f"{part('projection_parameters', projection)}")
    return path


def opencv(model, k):
    a, b = ideal_points()
    points = np.stack([a, b, np.ones_like(a)], axis=1)[:, None]
    nothing = np.zeros(3)
    return model.projectPoints(points, nothing, nothing, K, np.array(k))[0].reshape(-1, 2)


def test_pinhole_is_that_of_opencv(tmp_path):
    focal = dict(fx=300.0, fy=303.0, cx=318.5, cy=241.25)
    read = load_camera_map(camera(tmp_path / "c.yaml", "PINHOLE",
                                  dict(zip(("k1", "k2", "p1", "p2"), K4)), focal))
    np.testing.assert_allclose(np.stack(read.distort(*ideal_points()), axis=1), opencv(cv2, K4),
                               atol=1e-6)
    k = [.31, .02, .0008, -.0011, .001, .66, .08, .003]
    names = "k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"
    read = load_camera_map(camera(tmp_path / "f.yaml", "PINHOLE_FULL", dict(zip(names, k)), focal))
    np.testing.assert_allclose(np.stack(read.distort(*ideal_points()), axis=1), opencv(cv2, k),
                               atol=1e-6)


@pytest.mark.parametrize("within", ["projection", "distortion"])
def test_kannala_brandt_is_the_fisheye_of_opencv(tmp_path, within):
    k = dict(zip(("k2", "k3", "k4", "k5"), FISHEYE))
    focal = dict(mu=300.0, mv=303.0, u0=318.5, v0=241.25)
    read = load_camera_map(camera(tmp_path / "c.yaml", "KANNALA_BRANDT",
                                  k if within == "distortion" else {},
                                  focal if within == "distortion" else {**k, **focal}))
    np.testing.assert_allclose(np.stack(read.distort(*ideal_points()), axis=1),
                               opencv(cv2.fisheye, FISHEYE), atol=1e-6)


def test_mei_is_a_sphere_and_a_shifted_pinhole(tmp_path):
    k1, k2, p1, p2 = K4
    read = load_camera_map(camera(tmp_path / "c.yaml", "MEI", dict(k1=k1, k2=k2, p1=p1, p2=p2),
                                  dict(gamma1=700.0, gamma2=703.0, u0=318.5, v0=241.25),
                                  "mirror_parameters:\n   xi: 1.2\n"), zoom=.5)
    a, b = ideal_points()
    norm = np.sqrt(a * a + b * b + 1)
    x, y = a / (1 + 1.2 * norm), b / (1 + 1.2 * norm)
    r2 = x * x + y * y
    radial = k1 * r2 + k2 * r2 * r2
    x, y = (x + x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x),
            y + y * radial + 2 * p2 * x * y + p1 * (r2 + 2 * y * y))
    np.testing.assert_allclose(read.distort(a, b), (700 * x + 318.5, 703 * y + 241.25), atol=1e-9)


@pytest.mark.parametrize("model,projection,message", [
    ("SCARAMUZZA", {}, "model is SCARAMUZZA of camodocal, one of PINHOLE, PINHOLE_FULL, KANNALA"),
    ("KANNALA_BRANDT", dict(mu=300, mv=300, u0=320, v0=240), "lacks the value k2"),
    ("PINHOLE", dict(fx=300, fy=300, cx=320), "lacks the value k1"),
])
def test_others_are_named(tmp_path, model, projection, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(camera(tmp_path / "c.yaml", model, {}, projection))
