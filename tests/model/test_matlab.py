"""MATLAB's cameras: Bouguet's toolbox counts pixels from 0, cameraParameters from 1."""

import numpy as np
import pytest
import scipy.io

from camera_files import ideal_points
from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

FC, CC, KC, ALPHA = [657.39, 657.76], [302.98, 242.62], [-.2558, .1276, -.0002, .00003, .01], .002
SCRIPT = """% Intrinsic and Extrinsic Camera Parameters
%-- Focal length:
fc = [ 657.39 ; 657.76 ];

%-- Principal point:
cc = [ 302.98 ; 242.62 ];

%-- Skew coefficient:
alpha_c = 0.002;

%-- Distortion coefficients:
kc = [ -0.2558 ; 0.1276 ; -0.0002 ; ...
       0.00003 ; 0.01 ];

%-- Focal length uncertainty:
fc_error = [ 0.3 ; 0.4 ];

%-- Image size:
nx = 640;
ny = 480;

omc_1 = [ 1.65e+00 ; 1.65e+00 ; -6.7e-01 ];
"""


def toolbox(a, b, alpha=ALPHA):
    """Bouguet's description of the model, www.vision.caltech.edu/bouguetj, parameters.html."""
    r2 = a**2 + b**2
    radial = 1 + KC[0] * r2 + KC[1] * r2**2 + KC[4] * r2**3
    x = radial * a + 2 * KC[2] * a * b + KC[3] * (r2 + 2 * a**2)
    y = radial * b + KC[2] * (r2 + 2 * b**2) + 2 * KC[3] * a * b
    return FC[0] * (x + alpha * y) + CC[0], FC[1] * y + CC[1]


def test_calib_results_of_bouguet(tmp_path):
    script, mat = tmp_path / "Calib_Results.m", tmp_path / "Calib_Results.mat"
    script.write_text(SCRIPT)
    column = {name: np.array([value]).T for name, value in
              (("fc", FC), ("cc", CC), ("kc", KC), ("fc_error", FC))}
    scipy.io.savemat(mat, {**column, "alpha_c": ALPHA, "nx": 640.0, "ny": 480.0,
                           "x_1": np.zeros((2, 48))})
    a, b = (value / 2 for value in ideal_points())
    for path in (script, mat):
        read = load_camera_map(path)
        np.testing.assert_allclose(read.distort(a, b), toolbox(a, b), atol=1e-9)
        assert read.size == (640, 480) and read.model == "Bouguet"


def test_stereo_results_of_bouguet(tmp_path):
    table = {}
    for side, shift in (("left", 0), ("right", 20)):
        table |= {f"fc_{side}": FC, f"cc_{side}": np.add(CC, shift), f"kc_{side}": KC,
                  f"alpha_c_{side}": 0.0}
    scipy.io.savemat(tmp_path / "Calib_Results_stereo.mat", {**table, "nx": 640, "ny": 480})
    a, b = (value / 2 for value in ideal_points())
    with pytest.raises(InputError, match="holds the cameras left, right, one must be chosen"):
        load_camera_map(tmp_path / "Calib_Results_stereo.mat")
    read = load_camera_map(tmp_path / "Calib_Results_stereo.mat", camera="right")
    np.testing.assert_allclose(read.distort(a, b), np.add(toolbox(a, b, 0), 20), atol=1e-9)


@pytest.mark.parametrize("form", ["K", "IntrinsicMatrix"])
@pytest.mark.longer
def test_struct_of_camera_parameters_counts_from_one(tmp_path, form):
    matrix = np.array([[FC[0], FC[0] * ALPHA, CC[0] + 1], [0, FC[1], CC[1] + 1], [0, 0, 1]])
    struct = {form: matrix if form == "K" else matrix.T, "RadialDistortion": [*KC[:2], KC[4]],
              "TangentialDistortion": KC[2:4], "ImageSize": [480, 640]}
    scipy.io.savemat(tmp_path / "params.mat", {"params": struct})
    a, b = (value / 2 for value in ideal_points())
    read = load_camera_map(tmp_path / "params.mat")
    np.testing.assert_allclose(read.distort(a, b), toolbox(a, b), atol=1e-9)
    assert read.size == (640, 480)
    scipy.io.savemat(tmp_path / "stereo.mat", {"s": {
        "CameraParameters1": struct, "CameraParameters2": {**struct, "ImageSize": []}}})
    load_camera_map(tmp_path / "stereo.mat", camera="s.CameraParameters1")
    with pytest.raises(InputError, match="does not say the size of the image; --sensor-size"):
        load_camera_map(tmp_path / "stereo.mat", camera="s.CameraParameters2")


def mat(table):
    return lambda path: scipy.io.savemat(path, table)


@pytest.mark.parametrize("write,message", [
    (mat({"fc": FC, "cc": CC, "kc": KC[:4], "nx": 640, "ny": 480}), "kc has 4 coefficients, which"),
    (mat({"fc": FC, "kc": KC, "nx": 640, "ny": 480}), "the camera lacks the value cc"),
    (mat({"x": 3}), "it holds no camera: fc, cc and kc of Bouguet's"),
    (mat({"f": {"Intrinsics": {"MappingCoefficients": [1, 2, 3, 4], "ImageSize": [4, 4]}}}),
     "is a fisheyeParameters of MATLAB"),
    (lambda path: path.write_bytes(b"\x89HDF\r\n\x1a\n"), "version 7.3, which is not supported"),
    (lambda path: path.write_bytes(b"MATLAB 5.0 MAT-file"), "it is no .mat that can be read"),
    (lambda path: path.write_bytes(b""), "it is no .mat that can be read"),
])
def test_bad_files_are_named(tmp_path, write, message):
    write(tmp_path / "c.mat")
    with pytest.raises(InputError, match=message):
        load_camera_map(tmp_path / "c.mat")


def test_a_script_without_numbers_is_named(tmp_path):
    (tmp_path / "c.m").write_text(SCRIPT.replace("302.98", "x"))
    with pytest.raises(InputError, match="cc is .* x ; 242.62 .*, numbers are needed"):
        load_camera_map(tmp_path / "c.m")


def test_a_damaged_file_is_named(tmp_path):
    """SciPy's reader ends the whole process at this one: data of a kind that does not exist."""
    scipy.io.savemat(tmp_path / "c.mat", {"fc": np.array([FC]).T, "cc": np.array([CC]).T})
    content = (tmp_path / "c.mat").read_bytes()
    (tmp_path / "c.mat").write_bytes(content.replace(b"\x09\0\0\0", b"\x09\1\0\0"))
    with pytest.raises(InputError, match="it is no .mat that can be read: SciPy ended while it"):
        load_camera_map(tmp_path / "c.mat")
