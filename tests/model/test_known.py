"""Files of other software are named, never misread; so is whatever is no camera at all."""

import json
import pickle
from time import process_time

import numpy as np
import pytest

from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError
from photos import photos

METASHAPE = ('<?xml version="1.0" encoding="UTF-8"?>\n<calibration>\n  <projection>frame'
             "</projection>\n  <width>1920</width>\n  <f>1430</f>\n</calibration>\n")
ORB_SLAM = ('%YAML:1.0\n\nCamera.type: "PinHole"\nCamera.fx: 458.654\nCamera.fy: 457.296\n'
            "Camera.cx: 367.215\nCamera.cy: 248.375\nCamera.k1: -0.28\nCamera.width: 752\n")


@pytest.mark.parametrize("name,text,message", [
    ("c.xml", "<!DOCTYPE lensdatabase SYSTEM 'lensfun.dtd'>\n<lensdatabase>", "a lensfun profile"),
    ("c.xml", "<?xml version='1.0'?>\n<lensdatabase version='1'>", "a lensfun profile"),
    ("c.lcp", '<x:xmpmeta xmlns:x="adobe:ns:meta/">', "an Adobe lens profile"),
    ("c.xml", METASHAPE, "an Agisoft Metashape or PhotoScan XML"),
    ("c.xml", "<?xml version='1.0'?><kml></kml>", "its XML has the root kml, OpenCV's opencv_s"),
    ("imu.yaml", "rostopic: /imu0\nupdate_rate: 200.0\naccelerometer_noise_density: 0.01\n",
     "a Kalibr imu file"),
    ("chain.yaml", "imu0:\n  T_i_b: [1]\n  model: calibrated\n", "a Kalibr imu file"),
    ("sensor.yaml", "sensor_type: imu\nrate_hz: 200\n", "the file of a sensor of type imu"),
    ("april.yaml", "target_type: aprilgrid\ntagCols: 6\n", "a Kalibr target file"),
    ("g.json", json.dumps({"name": "x", "calib_dimension": {"w": 1920, "h": 1080},
                           "fisheye_params": {"camera_matrix": [], "distortion_coeffs": []}}),
     "a Gyroflow lens profile"),
    ("calib_results.txt", "#polynomial coefficients for the DIRECT mapping function (ocam_model.ss "
     "in MATLAB). These are used by cam2world\n\n5 -2.7e+02 0.0 -2.7e-06 1.8e-06 -8.0e-10\n",
     "an OCamCalib file with 1 lines of numbers, 5 are needed"),
    ("calibration.json", json.dumps({"value0": {"intrinsics": [{"camera_type": "ds"}]}}),
     "a basalt calibration"),
    ("orb.yaml", ORB_SLAM, "an ORB-SLAM settings file"),
    ("vins.yaml", "%YAML:1.0\n---\nimu: 1\ncam0_calib: \"cam0.yaml\"\nimage_width: 752\n",
     "a VINS settings file"),
    ("camera_models.json", json.dumps({"v2 x 1": {"projection_type": "dual", "width": 4}}),
     "a camera file of OpenSfM, whose camera v2 x 1 has the model dual; one of perspective"),
    ("sfm_data.json", json.dumps({"sfm_data_version": "0.3", "views": []}), "an OpenMVG sfm_data"),
    ("p.csv.txt", "photo,direction,line,y,x\n", "a points file of ncdc export --style discorpy"),
    ("images.txt", "# Image list with two lines of data per image:\n", "a COLMAP images.txt"),
    ("p.pto", "p f2 w3000 h1500 v360\ni w1280 h960 f3 v120\n", "a Hugin project"),
    ("x.yaml", "colour: red\nsize: 3\n", "none of the camera files that are known: its names are "
     "colour, size"),
    ("net.toml", "# NCDC descriptor: a trained camera\n", "a descriptor of ncdc train"),
    ("c.toml", "[cam_0]\nsize = [1920, 1080]\ndistortions = [0.1, 0, 0, 0]\n", "an Anipose or"),
    ("results-cam.txt", "Calibration results \n===\nCamera parameters:\n", "results file of"),
    ("c.json", json.dumps({"Calibration": {"cameras": []}}), "a calib.io calibration"),
    ("x.json", json.dumps({"hidden_neurons": 8}), "a report of ncdc"),
    ("lens.txt", "begin_cmr: Canon\nbegin_len: 50 mm\n", "a PTLens profile, which is not "
     "supported; where its program writes a map"),
    ("lens.ini", "a = 0.01\nb = -0.04\nc = 0.007\n", "a PTLens profile"),
    ("zivid.yml", "CameraIntrinsics:\n  CameraMatrix: {CX: 951.6, CY: 594.7, FX: 2760, FY: 2759}\n"
     "  Distortion: {K1: -0.27, K2: 0.35, K3: -0.32, P1: 0, P2: 0}\n",
     "a Zivid intrinsics file, which is not supported; write its focal lengths, centre, coeff"),
])
def test_known_text_is_named(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match=message) as caught:
        load_camera_map(tmp_path / name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name,message", [
    ("blender.json", "a transforms.json of Blender"),
    ("m_bool.yaml", "list of distortion coefficients holds true or false, numbers are needed"),
    ("opencv20736.yaml", "the lens model does not reach the left and right edges of the image: it "
     "ends at 38.9 degrees off its axis, where it has a pole or folds back; check the coef"),
    ("opensfm_fish62.json", "a camera file of OpenSfM, whose camera v2 x has the model fisheye62"),
    ("ptlens.ini", "a PTLens profile"),
    ("transforms_perframe.json", "a transforms.json of NeRF programs whose frames have each a lens "
     "of their own, with k1 and others; --camera a.png takes that of one frame")])
def test_cases_are_rejected_by_name(name, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(*photos(f"cameras/{name}"))


def test_what_the_cases_are_told_to_do_works():
    read = load_camera_map(*photos("cameras/transforms_perframe.json"), camera="a.png")
    r2 = .3 * .3
    np.testing.assert_allclose(read.distort(.3, 0.0), (
        805.625 + 731.25 * (.3 * (1 - .271 * r2 + .083 * r2**2) - .0007 * 3 * r2),
        588.25 + 735.5 * .0009 * r2))
    read = load_camera_map(*photos("cameras/opencv20736.yaml"), zoom=1)
    assert any("ends at 38.9 degrees off its axis" in text for text in read.warnings)


@pytest.mark.parametrize("name,text,message", [
    ("c.yaml", "a: [" + "1, " * 400_000 + "]", "1200005 characters of YAML or other text, the lim"),
    ("c.yaml", "".join(f"a{k}: &a{k} [*a{k - 1}, *a{k - 1}]\n" if k else "a0: &a0 [1, 1]\n"
                       for k in range(20)), "more than 16 aliases of YAML"),
    ("c.yaml", "a: &a\n  b: *a\n", "nested too deep, or holds itself"),
    ("c.json", '{"a": "' + "x" * (1 << 25) + '"}', "33554441 bytes, the limit is 33554432"),
    ("c.yml", "%YAML:1.0\n---\na: [" + "1, " * 20_001 + "1]\n", "than 20000 values outside of its"),
    ("c.txt", "\n" * 80_000, "holds no names and values")])
def test_large_files_are_rejected_soon(tmp_path, name, text, message):
    (tmp_path / name).write_text(text)
    start = process_time()
    with pytest.raises(InputError, match=message):
        load_camera_map(tmp_path / name)
    assert process_time() - start < 10


@pytest.mark.parametrize("content,message", [
    (pickle.dumps({"mtx": [1]}, 4), "a pickle of Python"), (b"SQLite format 3\0", "an SQLite"),
    (b"#ROSBAG V2.0\n", "a ROS bag"), (b"PK\x03\x04", "a ZIP archive")])
def test_known_bytes_are_named(tmp_path, content, message):
    (tmp_path / "file").write_bytes(content)
    with pytest.raises(InputError, match=message):
        load_camera_map(tmp_path / "file")
