"""Camchains of Kalibr: each model and its published formula, choice of camera, rejected files."""

import json

import numpy as np
import pytest

from camera_files import FISHEYE, MATRIX, ideal_points, opencv_file
from ncdc.cli import main
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

PINHOLE = [300.0, 300.0, 318.5, 241.25]


def entry(model="pinhole", own=(), distortion="none", coefficients=()):
    return {"camera_model": model, "intrinsics": [*own, *PINHOLE], "resolution": [640, 480],
            "distortion_model": distortion, "distortion_coeffs": list(coefficients),
            "rostopic": "/cam0/image_raw"}


def camchain(path, *cameras):
    # YAML holds JSON.
    path.write_text(json.dumps({f"cam{k}": camera for k, camera in enumerate(cameras)}))
    return path


def pixels(x, y):
    return MATRIX[0, 0] * x + MATRIX[0, 2], MATRIX[1, 1] * y + MATRIX[1, 2]


@pytest.mark.parametrize("distortion,coefficients,opencv", [
    ("radtan", [-.09, .006, .0008, -.0011], {}),
    ("equidistant", FISHEYE, {"distortion_model": "fisheye"}),
    ("equi", FISHEYE, {"distortion_model": "fisheye"}),
])
def test_pinhole_models_equal_those_of_opencv(tmp_path, distortion, coefficients, opencv):
    ours = load_camera_map(camchain(tmp_path / "chain.yaml",
                                    entry("pinhole", (), distortion, coefficients)))
    theirs = load_camera_map(opencv_file(tmp_path / "c.yml", coefficients, **opencv))
    np.testing.assert_allclose(ours.distort(*ideal_points()), theirs.distort(*ideal_points()),
                               atol=1e-9)
    assert ours.size == (640, 480) and ours.model.startswith("cam0 pinhole")


def unit_vectors():
    a, b = ideal_points()
    z = 1 / np.sqrt(a * a + b * b + 1)
    return a * z, b * z, z


@pytest.mark.parametrize("xi", [0.0, .8, 1.2])
def test_omni_is_a_sphere_seen_from_behind_its_centre(tmp_path, xi):
    k1, k2, p1, p2 = -.05, .01, .001, -.002
    read = load_camera_map(camchain(tmp_path / "chain.yaml",
                                    entry("omni", [xi], "radtan", [k1, k2, p1, p2])), zoom=.5)
    x, y, z = unit_vectors()
    x, y = x / (z + xi), y / (z + xi)
    q = x * x + y * y
    scale = 1 + k1 * q + k2 * q * q
    np.testing.assert_allclose(
        read.distort(*ideal_points()),
        pixels(x * scale + 2 * p1 * x * y + p2 * (q + 2 * x * x),
               y * scale + p1 * (q + 2 * y * y) + 2 * p2 * x * y), atol=1e-9)


def test_double_sphere_passes_two_spheres(tmp_path):
    xi, alpha = -.2, .59
    read = load_camera_map(camchain(tmp_path / "chain.yaml", entry("ds", [xi, alpha])))
    x, y, z = unit_vectors()
    # On the second sphere, whose centre is xi from the first's; then a pinhole.
    x, y, z = np.array([x, y, z + xi]) / np.sqrt(x * x + y * y + (z + xi)**2)
    offset = alpha / (1 - alpha)
    # The focal length of the model is (1 - alpha) of the shifted pinhole's.
    depth = (1 - alpha) * (z + offset)
    np.testing.assert_allclose(read.distort(*ideal_points()), pixels(x / depth, y / depth),
                               atol=1e-9)


def test_extended_unified_model_without_stretch_is_the_unified_one(tmp_path):
    alpha = .6
    read = load_camera_map(camchain(tmp_path / "chain.yaml", entry("eucm", [alpha, 1.0])))
    x, y, z = unit_vectors()
    depth = alpha + (1 - alpha) * z
    np.testing.assert_allclose(read.distort(*ideal_points()), pixels(x / depth, y / depth),
                               atol=1e-9)


def test_field_of_view_model_bends_the_angle_evenly(tmp_path):
    w = .9
    read = load_camera_map(camchain(tmp_path / "chain.yaml", entry("pinhole", (), "fov", [w])))
    angle = np.array([.2, .5, .7])
    radius = np.tan(angle * w) / (2 * np.tan(w / 2))
    x, y = read.distort(radius, np.zeros(3))
    np.testing.assert_allclose(x, 318.5 + 300 * angle, atol=1e-9)
    np.testing.assert_allclose(read.distort(0.0, 0.0), (318.5, 241.25))


@pytest.mark.longer
def test_one_camera_of_several_is_chosen_by_name(tmp_path, capsys):
    chain = camchain(tmp_path / "chain.yaml", entry("pinhole", (), "radtan", [-.02, 0, 0, 0]),
                     entry("pinhole", (), "radtan", [-.08, 0, 0, 0]))
    first, second = (load_camera_map(chain, camera=name) for name in ("cam0", "cam1"))
    assert first.distort(.5, 0)[0] > second.distort(.5, 0)[0] + 1
    with pytest.raises(InputError, match="holds the cameras cam0, cam1, one must be chosen"):
        load_camera_map(chain)
    net = tmp_path / "net.toml"
    train = ["train", str(chain), "--neurons", "2", "-o", str(net), "--size", "160x120"]
    assert main([*train, "--camera", "cam7"]) == 2
    assert "camera cam7 is asked for, the file holds cam0, cam1" in capsys.readouterr().err
    assert main([*train, "--camera", "cam1"]) == 0
    assert "cam1 pinhole radtan" in net.read_text()
    errors = [tmp_path / f"{name}.json" for name in ("cam0", "cam1")]
    for file in errors:
        assert main(["evaluate", str(net), "--reference", str(chain), "--camera", file.stem,
                     "--json", str(file)]) == 0
    other, own = (json.loads(file.read_text())["map_error_float_px"]["mse"] for file in errors)
    assert own < other / 10


@pytest.mark.parametrize("camera,message", [
    (entry("spherical"), "cam0 has the model 'spherical', one of pinhole, omni, eucm, ds"),
    (entry("ds", [0, .5], "radtan"), "cam0 has the distortion 'radtan', with ds one of none"),
    (entry("omni", ()), "list of intrinsics has 4 numbers, 5 are needed"),
    (entry("pinhole", (), "radtan", [.1] * 5), "cam0 radtan has 5 coefficients, 4 are needed"),
    (entry("pinhole", (), "fov", [4.0]), "field of view is 4 rad, it must lie between 0 and pi"),
    (entry() | {"resolution": [640]}, "a value of the wrong kind"),
    ({"camera_model": "pinhole"}, "lacks the value distortion_model"),
])
def test_unsupported_cameras_are_named(tmp_path, camera, message):
    path = camchain(tmp_path / "chain.yaml", camera)
    with pytest.raises(InputError, match=message) as caught:
        load_camera_map(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_a_camera_is_chosen_only_where_there_are_several(tmp_path):
    with pytest.raises(InputError, match="cam1 is asked for, the file holds one camera without"):
        load_camera_map(opencv_file(tmp_path / "c.yml", FISHEYE), camera="cam1")
