"""The .ini of camera_calibration_parsers: the map of OpenCV."""

import cv2
import numpy as np
import pytest

from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

# As ost.txt of camera_calibration, and as writeCalibrationIni of camera_calibration_parsers.
TEXT = """# oST version 5.0 parameters


[image]

width
640

height
480

[narrow_stereo/left]

camera matrix
420.50000 0.00000 325.50000
0.00000 418.00000 236.25000
0.00000 0.00000 1.00000

distortion
{}

rectification
0.99981 -0.01872 -0.00468
0.01874 0.99981 0.00450
0.00460 -0.00459 0.99998

projection
390.00000 0.00000 318.00000 -40.50000
0.00000 390.00000 244.00000 0.00000
0.00000 0.00000 1.00000 0.00000
"""
K = np.array([[420.5, 0, 325.5], [0, 418, 236.25], [0, 0, 1]])
R = np.array([[.99981, -.01872, -.00468], [.01874, .99981, .0045], [.0046, -.00459, .99998]])
P = np.array([[390.0, 0, 318], [0, 390, 244], [0, 0, 1]])


@pytest.mark.parametrize("k,kind", [
    ([-.25, .12, .0008, -.0011, -.03], "perspective with 5"),
    ([.31, .02, .0008, -.0011, .001, .66, .08, .003], "perspective with 8")])
@pytest.mark.parametrize("name", ["cam.ini", "ost.txt"])
def test_map_is_that_of_opencv(tmp_path, k, kind, name):
    (tmp_path / name).write_text(TEXT.format(" ".join(map(str, k))))
    read = load_camera_map(tmp_path / name, camera="narrow_stereo/left")
    u, v = np.meshgrid(np.arange(640), np.arange(480))
    theirs = cv2.initUndistortRectifyMap(K, np.array(k), R, P, (640, 480), cv2.CV_32FC1)
    for ours, table in zip(read.back_map(u, v), theirs):
        np.testing.assert_allclose(ours, table, atol=1e-4)
    assert read.size == (640, 480) and read.model.startswith(kind)


@pytest.mark.parametrize("change,message", [
    (("418.00000", "x"), "stands where numbers are needed"),
    (("height\n480", ""), "lacks the value image_height"),
    (("camera matrix\n420.50000 0.00000", "camera matrix\n420.5"), "has 8 numbers, 9 are needed"),
])
def test_mistakes_are_named(tmp_path, change, message):
    (tmp_path / "c.ini").write_text(TEXT.format("0 0 0 0 0").replace(*change))
    with pytest.raises(InputError, match=message):
        load_camera_map(tmp_path / "c.ini")
