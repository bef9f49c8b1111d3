"""Whatever may be distortion is read or named: no reader takes an unknown entry for none."""

import json

import numpy as np
import pytest
import yaml

from camera_files import FISHEYE, MATRIX
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_model.calibration.files.unread import may_bend
from ncdc_spec.errors import InputError

OPENCV = {"image_width": 640, "image_height": 480, "camera_matrix": MATRIX.ravel().tolist()}
K4 = [-.09, .006, .0008, -.0011]
BENT = {**OPENCV, "distortion_coefficients": K4}
KALIBR = {"cam0": {"camera_model": "pinhole", "intrinsics": [300, 300, 318.5, 241.25],
                   "distortion_model": "radtan", "distortion_coeffs": K4, "resolution": [640, 480]}}
NERF = {"w": 640, "h": 480, "fl_x": 300.0, "cx": 319, "cy": 241, "camera_model": "OPENCV", "k1": .1}
REALSENSE = {"width": 640, "height": 480, "ppx": 318.5, "ppy": 241.25, "fx": 300, "fy": 300,
             "model": "brown_conrady", "coeffs": K4 + [0.0]}
CAMODOCAL = {"model_type": "PINHOLE", "image_width": 640, "image_height": 480,
             "distortion_parameters": dict(zip(("k1", "k2", "p1", "p2"), K4)),
             "projection_parameters": {"fx": 300, "fy": 300, "cx": 318.5, "cy": 241.25}}


def read(tmp_path, table):
    path = tmp_path / "c.json"
    path.write_text(json.dumps(table))
    return load_camera_map(path)


@pytest.mark.parametrize("entry", [
    {"distortion_vector": K4}, {"Distortion": K4}, {"lens": {"distortion": K4}}, {"k1": .1},
    {"K1": .1, "K2": .2}, {"k_1": "0.1"}, {"poly": [1, .1]}, {"xi": None, "Xi": 1.1}, {"alpha": .6},
    {"dist_coef": {"rows": 1, "cols": 4, "data": K4}}, {"radialDistortion": K4}, {"P1": .001},
    {"cam": [{"coefficients": K4}]}, {"fish_eye": True}, {"lens_type": "fisheye"},
    {"kannala_brandt": FISHEYE}, {"invpol": [5.0]}, {"DistCoeffs": "0.1 0.2 0 0"},
    {"mirror_offset": 1.1}, {"bowing": [.1]}, {"lens": {"x": .3}}, {"lens": [[.1, .2], [0, 1]]}])
def test_an_unknown_entry_is_no_absence_of_distortion(tmp_path, entry):
    """Also of a name that says nothing, where no distortion is read."""
    with pytest.raises(InputError, match=f"entry ({'|'.join(entry)}).* may be"):
        read(tmp_path, OPENCV | entry)


@pytest.mark.parametrize("entry", [
    {"k7": .1}, {"model": {"thin_prism": .1}}, {"D": K4}, {"tangential": [.1, .2]},
    {"distortion": {"k": [0, .1]}}])
@pytest.mark.parametrize("table", [BENT, KALIBR, NERF, REALSENSE, CAMODOCAL])
def test_each_reader_knows_what_it_has_read(tmp_path, table, entry):
    read(tmp_path, table)
    if "model" in entry:
        entry = {"extra": entry["model"]}
    inner = {"cam0": table["cam0"] | entry} if "cam0" in table else table | entry
    with pytest.raises(InputError, match=f"entry {list(entry)[0]}.* may be distortion"):
        read(tmp_path, inner)


@pytest.mark.parametrize("entry", [
    {"k7": 0}, {"distortion_notes": None}, {"tau_x": 0.0, "poly": []}, {"fisheye_model": 0},
    {"avg_reprojection_error": .2, "nframes": 13, "flags": 0, "calibration_time": "Tue"},
    {"board_width": 9, "square_size": 2.5, "rvecs": [[1, 2, 3]], "focus_distance": 1.5},
    {"camera_name": "fisheye_front"}, {"R1": np.eye(3).tolist(), "P1": np.ones((3, 4)).tolist()},
    {"rms_error": .2, "extrinsics": {"r": [1, 2], "offset": 3}}])
def test_what_is_none_is_left_alone(tmp_path, entry):
    assert read(tmp_path, BENT | entry).model == "perspective with 4 coefficients"
    assert any("no distortion coefficients" in text for text in read(tmp_path, OPENCV | entry
                                                                     ).warnings)


def test_a_file_that_states_none_may_hold_what_it_likes(tmp_path):
    table = OPENCV | {"distortion_model": "none", "bowing": [.1]}
    assert read(tmp_path, table).warnings == ()
    with pytest.raises(InputError, match="entry k1 may be distortion"):
        read(tmp_path, table | {"k1": .1})


def test_a_nerf_camera_without_distortion(tmp_path):
    table = {name: value for name, value in NERF.items() if name != "k1"}
    assert read(tmp_path, table | {"k1": None, "aabb_scale": 16}).warnings
    with pytest.raises(InputError, match="no distortion under .*, and the entry bowing may be"):
        read(tmp_path, table | {"bowing": .1})


def test_coefficients_that_are_missing(tmp_path):
    for table, name in ((KALIBR, "distortion_coeffs"), (REALSENSE, "coeffs")):
        table = json.loads(json.dumps(table))
        table.get("cam0", table).pop(name)
        with pytest.raises(InputError, match=f"lacks the value {name}"):
            read(tmp_path, table)
    (tmp_path / "c.m").write_text("fc = [ 657 ; 657 ];\ncc = [ 302 ; 242 ];\nnx = 640;\nny = 480;")
    with pytest.raises(InputError, match="lacks the value kc"):
        load_camera_map(tmp_path / "c.m")
    ini = "[image]\n\nwidth\n640\n\nheight\n480\n\n[cam]\n\ncamera matrix\n300 0 318\n0 300 241\n" \
          "0 0 1\n\n"
    for more, message in (("", "lacks the value distortion_coefficients"),
                          ("distortion\n0 0 0 0 0\n\ndistortion2\n.1 .2\n",
                           "line 'distortion2' may be distortion")):
        (tmp_path / "c.ini").write_text(ini + more)
        with pytest.raises(InputError, match=message):
            load_camera_map(tmp_path / "c.ini")


def test_an_array_that_is_no_table_of_numbers(tmp_path):
    lists = np.empty(2, object)
    lists[:] = [[.1], [.2]]
    np.savez(tmp_path / "c.npz", mtx=MATRIX, size=[640, 480], dist=lists)
    with pytest.raises(InputError, match="dist may be distortion, but is no array"):
        load_camera_map(tmp_path / "c.npz", sensor=(640, 480))


def test_k1_and_k2_are_no_pair_of_cameras(tmp_path):
    with pytest.raises(InputError, match="none of the camera files that are known: its names are"):
        read(tmp_path, {"fx": 300, "k1": .1, "k2": .2, "p1": 0, "p2": 0})
    pair = {"K1": MATRIX.tolist(), "K2": MATRIX.tolist(), "D2": K4, "image_size": [640, 480]}
    with pytest.raises(InputError, match="holds the cameras 1, 2, one must be chosen"):
        read(tmp_path, pair)
    alone = {"M1": MATRIX.tolist(), "D_left": K4, "image_size": [640, 480]}
    with pytest.raises(InputError, match="entry D_left may be distortion"):
        read(tmp_path, alone)


@pytest.mark.parametrize("text", [
    yaml.safe_dump(BENT | {"distortion_coefficients": [True, 0, 0, 0]}),
    yaml.safe_dump(KALIBR).replace("- 300\n", "- yes\n", 1),
    json.dumps(NERF | {"k1": True}), json.dumps(NERF | {"k1": False}),
    json.dumps(REALSENSE | {"width": True}),
    "%YAML:1.0\n---\nimage_width: 640\nimage_height: 480\nK: !!opencv-matrix\n   rows: 3\n"
    "   cols: 3\n   dt: d\n   data: [ 300., 0., true, 0., 300., 241., 0., 0., 1. ]\nD: [0., 0.]\n",
    json.dumps(BENT | {"camera_matrix": {"type_id": "opencv-matrix", "rows": 3, "cols": 3,
                                         "dt": "d", "data": [300, 0, 318, 0, True, 241, 0, 0, 1]}}),
    "%YAML:1.0\n---\nimage_width: true\nimage_height: 480\nK: [1, 0, 0, 0, 1, 0, 0, 0, 1]\n"])
def test_true_is_no_number(tmp_path, text):
    (tmp_path / "c.yaml").write_text(text)
    with pytest.raises(InputError, match="true|number"):
        load_camera_map(tmp_path / "c.yaml")


def test_names():
    assert all(map(may_bend, ("k1", "lensK2", "DIST", "distCoeff", "xi", "p_2", "tauX", "kc", "a")))
    assert not any(map(may_bend, ("distance", "focusDistance", "distribution", "polygon", "width",
                                  "T_cam_imu", "camera_name", "reprojection_error")))
