"""MC-Calib: the file of its FileStorage calls, its two models by OpenCV."""

import cv2
import numpy as np
import pytest

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError
from photos import photos

K = np.array([[480.0, 0, 640], [0, 481, 479], [0, 0, 1]])
VECTORS = {0: [-.09, .006, .0008, -.0011, .004], 1: [.02, -.004, .001, -.0002]}


def write(path, *cameras):
    """A file with the calls of MC-Calib's saveCamerasParams; a camera is a dict of changes."""
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_WRITE)
    storage.write("nb_camera", len(cameras))
    for number, change in enumerate(cameras):
        storage.startWriteStruct(f"camera_{number}", cv2.FILE_NODE_MAP)
        kind = change.get("distortion_type", 0)
        values = {"camera_matrix": K, "distortion_vector": np.array([VECTORS[0]]),
                  "distortion_type": kind, "camera_group": 0, "img_width": 1280,
                  "img_height": 960, "camera_pose_matrix": np.eye(4)} | change
        for name, value in values.items():
            if value is not None:
                storage.write(name, value)
        storage.endWriteStruct()
    storage.release()
    return path


def vector(kind):
    return {"distortion_type": kind, "distortion_vector": np.array([VECTORS[kind]])}


@pytest.mark.parametrize("camera,lens,k", [("camera_0", cv2, VECTORS[0]),
                                           ("camera_1", cv2.fisheye, VECTORS[1])])
def test_both_types_are_those_of_opencv(tmp_path, camera, lens, k):
    path = write(tmp_path / "c.yml", vector(0), vector(1))
    with pytest.raises(InputError, match="holds the cameras camera_0, camera_1, one must be"):
        load_camera_map(path)
    read = load_camera_map(path, camera=camera)
    a, b = ideal_points()
    theirs = lens.projectPoints(np.stack([a, b, np.ones_like(a)], axis=1)[:, None], np.zeros(3),
                                np.zeros(3), K, np.array(k))[0].reshape(-1, 2)
    np.testing.assert_allclose(np.stack(read.distort(a, b), axis=1), theirs, atol=1e-9)
    assert read.size == (1280, 960)


def test_the_file_of_the_case():
    read = load_camera_map(*photos("cameras/mccal.yml"))
    assert read.size == (1280, 960) and read.model == "MC-Calib Kannala-Brandt"
    angle = np.arctan(.9)
    bent = angle * (1 + .02 * angle**2 - .004 * angle**4 + .001 * angle**6 - .0002 * angle**8)
    np.testing.assert_allclose(read.distort(.9, 0.0), (640 + 480 * bent, 479))


@pytest.mark.parametrize("change,message", [
    ({**vector(1), "distortion_type": 2}, "distortion_type is 2, 0 .Brown. or 1"),
    ({**vector(0), "distortion_type": None}, "lacks the value distortion_type"),
    ({**vector(0), "distortion_vector": None}, "lacks the value distortion_vector"),
    ({**vector(0), "distortion_type": 1}, "Kannala-Brandt has 5 coefficients, 4 are needed"),
    ({**vector(0), "k7": .1}, "entry k7 may be distortion"),
    ({**vector(0), "img_width": 12.5}, "image width is 12.5, a whole number"),
])
def test_bad_values_are_named(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(write(tmp_path / "c.yml", change))
