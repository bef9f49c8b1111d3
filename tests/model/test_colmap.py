"""Cameras of COLMAP: every model gives the pixels of pycolmap, from the files that it writes."""

import numpy as np
import pycolmap
import pytest

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

FX, FY, CX, CY = 300.0, 303.0, 318.5, 241.25
MODELS = {
    "SIMPLE_PINHOLE": [FX, CX, CY], "PINHOLE": [FX, FY, CX, CY],
    "SIMPLE_RADIAL": [FX, CX, CY, -.08], "RADIAL": [FX, CX, CY, -.09, .006],
    "OPENCV": [FX, FY, CX, CY, -.09, .006, .0008, -.0011],
    "FULL_OPENCV": [FX, FY, CX, CY, .31, .02, .0008, -.0011, .001, .66, .08, .003],
    "OPENCV_FISHEYE": [FX, FY, CX, CY, .02, -.006, .002, -.0005], "FOV": [FX, FY, CX, CY, .9],
    "SIMPLE_RADIAL_FISHEYE": [FX, CX, CY, -.02], "RADIAL_FISHEYE": [FX, CX, CY, -.02, .004],
    "THIN_PRISM_FISHEYE": [FX, FY, CX, CY, .02, -.006, .0008, -.0011, .002, -.0005, .003, -.002],
    "SIMPLE_FISHEYE": [FX, CX, CY], "FISHEYE": [FX, FY, CX, CY]}


def written(folder, *cameras):
    """Files cameras.txt and cameras.bin that COLMAP writes of (model, parameters)."""
    model = pycolmap.Reconstruction()
    for number, (name, params) in enumerate(cameras, 1):
        model.add_camera_with_trivial_rig(pycolmap.Camera(
            camera_id=number, model=name, width=640, height=480, params=params))
    model.write_text(str(folder))
    model.write_binary(str(folder))
    return folder / "cameras.txt", folder / "cameras.bin"


@pytest.mark.parametrize("name", MODELS)
def test_every_model_gives_the_pixels_of_colmap(tmp_path, name):
    a, b = ideal_points()
    camera = pycolmap.Camera(camera_id=1, model=name, width=640, height=480, params=MODELS[name])
    theirs = np.array(camera.img_from_cam(np.stack([a, b, np.ones_like(a)], axis=1)))
    for path in written(tmp_path, (name, MODELS[name])):
        read = load_camera_map(path, zoom=.5)
        # COLMAP's pixel (0.5, 0.5) is the centre of the first one, ours (0, 0).
        np.testing.assert_allclose(np.stack(read.distort(a, b), axis=1), theirs - .5, atol=1e-6)
        assert read.size == (640, 480) and read.model == f"COLMAP {name}"


def test_a_camera_is_chosen_by_its_id(tmp_path):
    others = [("RAD_TAN_THIN_PRISM_FISHEYE", [FX, FY, CX, CY] + [0] * 12),
              ("EUCM", [FX, FY, CX, CY, .5, 1.1]), ("SIMPLE_DIVISION", [FX, CX, CY, .1]),
              ("DIVISION", [FX, FY, CX, CY, .1])]
    paths = written(tmp_path, *others, ("PINHOLE", [200, 201, CX, CY]), ("PINHOLE", MODELS[
        "PINHOLE"]))
    for path in paths:
        with pytest.raises(InputError, match="cameras 1, 2, 3, 4, 5, 6, one must be chosen"):
            load_camera_map(path)
        with pytest.raises(InputError, match="camera 9 is asked for, the file holds 1, 2"):
            load_camera_map(path, camera="9")
        with pytest.raises(InputError, match="camera 2 has the model EUCM, one of SIMPLE_PINHOLE"):
            load_camera_map(path, camera="2")
        assert load_camera_map(path, camera="5").distort(1.0, 0.0)[0] == CX - .5 + 200


@pytest.mark.parametrize("content", [b"", b"\x01" + bytes(7), b"\x01" + bytes(100), bytes(8)])
def test_a_broken_binary_file_is_named(tmp_path, content):
    (tmp_path / "cameras.bin").write_bytes(content)
    with pytest.raises(InputError, match="it is no cameras.bin of COLMAP"):
        load_camera_map(tmp_path / "cameras.bin")


@pytest.mark.parametrize("line,message", [
    ("1 OPENCV 640 480 300 300 320 240 0 0 0", "model OPENCV has 7 numbers, 8 are needed"),
    ("1 PINHOLE 640 480 300 300 320 nan", "holds a number that is not finite"),
    ("1 PINHOLE 640 480 300 300 320 x", "a value of the wrong kind"),
    ("1 PINHOLE 640 480 -300 300 320 240", "focal lengths are -300 and 300"),
    ("1 WIDE 640 480 300 300 320 240", "camera 1 has the model WIDE, one of SIMPLE_PINHOLE"),
])
def test_a_bad_line_is_named(tmp_path, line, message):
    (tmp_path / "cameras.txt").write_text(f"# Camera list\n{line}\n")
    with pytest.raises(InputError, match=message):
        load_camera_map(tmp_path / "cameras.txt")
