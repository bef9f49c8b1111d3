"""OAK cameras: oak.json was written by depthai 3.12.0, which gave back the numbers below.

depthai is no dependency of the tests, as its wheel has 96 MB.
"""

import json

import cv2
import numpy as np
import pytest

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError
from photos import photos

# getDefaultIntrinsics and getDistortionCoefficients of CalibrationHandler("oak.json").
CAM_A = ([[1501.5, 0, 963.25], [0, 1499.75, 530.5], [0, 0, 1]], (1920, 1080),
         [0.3100000023841858, 0.019999999552965164, 0.0007999999797903001, -0.0010999999940395355,
          0.0010000000474974513, 0.6600000262260437, 0.07999999821186066, 0.003000000026077032,
          0.0012000000569969416, 0.00019999999494757503, -0.000699999975040555,
          9.999999747378752e-05, 0.010999999940395355, -0.00800000037997961])
CAM_B = ([[781.5, 0, 645.25], [0, 780.75, 388.5], [0, 0, 1]], (1280, 800),
         [0.019999999552965164, -0.006000000052154064, 0.0020000000949949026,
          -0.0005000000237487257])


def oak(path, socket, **change):
    """oak.json with entries of one socket changed; None takes one out."""
    table = json.loads(photos("cameras/oak.json")[0].read_text())
    for number, entry in table["cameraData"]:
        if number == socket:
            entry.update(change)
            for name in [name for name, value in change.items() if value is None]:
                del entry[name]
    path.write_text(json.dumps(table))
    return path


@pytest.mark.parametrize("camera,known,lens", [("CAM_A", CAM_A, cv2),
                                               ("CAM_B", CAM_B, cv2.fisheye)])
def test_sockets_have_the_numbers_of_depthai(camera, known, lens):
    path, = photos("cameras/oak.json")
    with pytest.raises(InputError, match="holds the cameras CAM_A, CAM_B, one must be chosen"):
        load_camera_map(path)       # CAM_C has a field of view only
    read = load_camera_map(path, camera=camera)
    matrix, size, k = known
    a, b = ideal_points()
    theirs = lens.projectPoints(np.stack([a, b, np.ones_like(a)], axis=1)[:, None], np.zeros(3),
                                np.zeros(3), np.array(matrix, float), np.array(k))[0]
    np.testing.assert_allclose(np.stack(read.distort(a, b), axis=1), theirs.reshape(-1, 2),
                               atol=1e-9)
    assert read.size == size and not read.warnings


@pytest.mark.parametrize("change,message", [
    ({"cameraType": 3}, "CAM_B has the cameraType 3 of DepthAI, 0 .perspective. or 1"),
    ({"cameraType": None}, "lacks the value cameraType"),
    ({"cameraType": True}, "cameraType is true, a number is needed"),
    ({"distortionCoeff": [.1, 0, 0, 0, .1]}, "fisheye has 5 coefficients, 4 are needed"),
    ({"distortionCoeff": None}, "lacks the value distortionCoeff"),
    ({"rollingPolynomial": [.1]}, "entry rollingPolynomial may be distortion"),
    ({"intrinsicMatrix": [[1, 0, 2], [0, 1, 3]]}, "camera matrix has 6 numbers, 9 are needed"),
])
def test_bad_values_are_named(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(oak(tmp_path / "oak.json", 1, **change), camera="CAM_B")


def test_no_coefficients_are_warned_of(tmp_path):
    read = load_camera_map(oak(tmp_path / "oak.json", 0, distortionCoeff=[]), camera="CAM_A")
    assert any("holds no distortion coefficients" in text for text in read.warnings)


def test_a_file_without_a_calibrated_camera(tmp_path):
    (tmp_path / "oak.json").write_text(json.dumps({"cameraData": [[0, {"intrinsicMatrix": []}]]}))
    with pytest.raises(InputError, match="DepthAI .OAK. file without a calibrated camera"):
        load_camera_map(tmp_path / "oak.json")
