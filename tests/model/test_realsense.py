"""Intrinsics of librealsense: the pixels of pyrealsense2."""

import json

import numpy as np
import pytest

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

pyrealsense2 = pytest.importorskip("pyrealsense2", reason="it has no wheels for this system")
K = {"none": [0.0] * 5, "brown_conrady": [.1, -.05, .002, .001, .03],
     "modified_brown_conrady": [.1, -.05, .002, .001, .03],
     "kannala_brandt4": [.02, -.006, .002, -.0005, 0], "ftheta": [.9, 0, 0, 0, 0]}
PRINTED = """ Intrinsic of "Depth" / 640x480 / {Z16}
  Width:        640
  Height:       480
  PPX:          320.5
  PPY:          240.25
  Fx:           390
  Fy:           391
  Distortion:   Brown Conrady
  Coeffs:       0       0       0       0       0
  FOV (deg):    78.7 x 63.1

 Intrinsic of "Color" / 1280x720 / {YUYV/RGB8}
  Width:        1280
  Height:       720
  PPX:          641.5
  PPY:          362.25
  Fx:           905
  Fy:           903
  Distortion:   Inverse Brown Conrady
  Coeffs:       0       0       0       0       0
  FOV (deg):    70.53 x 43.45
"""


def intrinsics(model, coeffs, **more):
    return {"width": 640, "height": 480, "ppx": 318.5, "ppy": 241.25, "fx": 300.0, "fy": 303.0,
            "model": model, "coeffs": coeffs, **more}


def write(path, table):
    path.write_text(json.dumps(table))
    return path


@pytest.mark.parametrize("spelling", ["{}", "distortion.{}", "RS2_DISTORTION_{}", "number",
                                      "words"])
@pytest.mark.parametrize("model", K)
def test_every_model_gives_the_pixels_of_librealsense(tmp_path, model, spelling):
    kind = getattr(pyrealsense2.distortion, model)
    theirs = pyrealsense2.intrinsics()
    for name, value in intrinsics(kind, K[model]).items():
        setattr(theirs, name, value)
    a, b = ideal_points()
    pixels = [pyrealsense2.rs2_project_point_to_pixel(theirs, [float(x), float(y), 1.0])
              for x, y in zip(a, b)]
    name = {"number": int(kind), "words": model.replace("_", " ").title()}.get(
        spelling, spelling.format(model.upper() if "RS2" in spelling else model))
    read = load_camera_map(write(tmp_path / "c.json", intrinsics(name, K[model])), zoom=.5)
    # librealsense computes in single precision.
    np.testing.assert_allclose(np.stack(read.distort(a, b), axis=1), pixels, atol=1e-4)
    assert read.model == f"RealSense {model}"


def test_inverse_model_is_read_without_coefficients_only(tmp_path):
    read = load_camera_map(write(tmp_path / "c.json", intrinsics("inverse_brown_conrady", [0] * 5)))
    np.testing.assert_allclose(read.distort(.5, -.2), (318.5 + 150, 241.25 - 60.6))
    for name in ("inverse_brown_conrady", "Inverse Brown Conrady", 2):
        with pytest.raises(InputError, match="inverse_brown_conrady with coefficients is not"):
            load_camera_map(write(tmp_path / "d.json", intrinsics(name, [.1, 0, 0, 0, 0])))


def test_one_of_several_streams_is_chosen(tmp_path):
    table = {"device": "D435", "streams": {"color": intrinsics("none", [0] * 5),
                                           "depth": intrinsics("none", [0] * 5, fx=400.0)}}
    path = write(tmp_path / "c.json", table)
    with pytest.raises(InputError, match="cameras streams.color, streams.depth, one must be"):
        load_camera_map(path)
    assert load_camera_map(path, camera="streams.depth").distort(1, 0)[0] == 718.5


def test_the_print_of_rs_enumerate_devices(tmp_path):
    (tmp_path / "rs.txt").write_text(PRINTED)
    with pytest.raises(InputError, match="cameras Depth 640x480, Color 1280x720, one must be"):
        load_camera_map(tmp_path / "rs.txt")
    read = load_camera_map(tmp_path / "rs.txt", camera="Color 1280x720")
    assert read.size == (1280, 720)
    np.testing.assert_allclose(read.distort(1, .5), (1546.5, 813.75))


@pytest.mark.parametrize("change,message", [
    ({"coeffs": [.1, 0, 0, 0, 0]}, "model is none, with coefficients that are not 0; one of mod"),
    ({"model": "wide"}, "distortion model is 'wide', one of none, modified_brown_conrady"),
    ({"coeffs": [0] * 4}, "list of coefficients has 4 numbers, 5 are needed"),
    ({"fx": "x"}, "a value of the wrong kind"), ({"model": None}, "lacks the value model or"),
])
def test_bad_values_are_named(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(write(tmp_path / "c.json", intrinsics("none", [0] * 5) | change))
