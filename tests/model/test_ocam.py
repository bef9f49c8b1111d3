"""OCamCalib: rays by the toolbox's own definition, and its two ways from a ray to a pixel."""

import numpy as np
import pytest
import scipy.io

from ncdc_model.calibration.camera_file import load_camera_map
from ncdc_spec.errors import InputError

# A fisheye of 800x600 whose rays are (x, y, f(r)) with row and column = A (x, y) + centre.
DIRECT = [-260.0, 0.0, 1.4e-3, -2.1e-6, 4.5e-9]
CENTRE, AFFINE, SIZE = (291.5, 402.25), (.9991, -.0004, .0002), (600, 800)


def inverse(degree=12):
    """The inverse polynomial, fitted to the direct one as the toolbox does."""
    r = np.linspace(0, 520, 2000)
    angle = np.arctan2(np.polynomial.Polynomial(DIRECT)(r), r)
    return np.polynomial.Polynomial.fit(angle, r, degree).convert().coef


def text(direct=DIRECT, back=None, centre=CENTRE, affine=AFFINE, size=SIZE):
    back = inverse() if back is None else back
    rows = [[len(direct), *direct], [len(back), *back], centre, affine, size]
    heads = ("polynomial coefficients for the DIRECT mapping function (ocam_model.ss in MATLAB)",
             "polynomial coefficients for the inverse mapping function", "center: row and column",
             "affine parameters", "image size: height and width")
    return "".join(f"#{head}\n\n{' '.join(map(repr, map(float, row)))}\n\n"
                   for head, row in zip(heads, rows))


def write(path, **change):
    path.write_text(text(**change))
    return path


def test_pixels_lie_on_the_rays_of_the_toolbox(tmp_path):
    read = load_camera_map(write(tmp_path / "calib_results.txt"), zoom=.5)
    assert read.size == (800, 600) and read.model == "OCamCalib" and not read.warnings
    columns, rows = (grid.ravel() for grid in np.meshgrid(np.linspace(60, 740, 9),
                                                          np.linspace(40, 560, 7)))
    c, d, e = AFFINE
    x, y = np.linalg.solve([[c, d], [e, 1]], [rows - CENTRE[0], columns - CENTRE[1]])
    z = np.polynomial.Polynomial(DIRECT)(np.hypot(x, y))
    front = z < -50
    assert front.sum() > 50
    # The toolbox looks along -z; its x goes down the rows, its y along the columns.
    a, b = y[front] / -z[front], x[front] / -z[front]
    np.testing.assert_allclose(read.distort(a, b), (columns[front], rows[front]), atol=1e-9)
    np.testing.assert_allclose(read.undistort(columns[front], rows[front]), (a, b), atol=1e-9)


def test_the_inverse_polynomial_gives_the_same_pixels(tmp_path):
    read = load_camera_map(write(tmp_path / "calib_results.txt"), zoom=.5)
    a, b = (grid.ravel() for grid in np.meshgrid(np.linspace(-2, 2, 8), np.linspace(-1.5, 1.5, 6)))
    radius = np.hypot(a, b)
    rho = np.polynomial.Polynomial(inverse())(np.arctan2(-1, radius))
    x, y = b / radius * rho, a / radius * rho
    c, d, e = AFFINE
    np.testing.assert_allclose(read.distort(a, b), (e * x + y + CENTRE[1], c * x + d * y +
                                                    CENTRE[0]), atol=.01)


def test_the_struct_counts_from_1(tmp_path):
    c, d, e = AFFINE
    scipy.io.savemat(tmp_path / "c.mat", {"ocam_model": {
        "ss": np.array([DIRECT]).T, "invpol": inverse()[::-1], "xc": CENTRE[0] + 1,
        "yc": CENTRE[1] + 1, "c": c, "d": d, "e": e, "height": 600.0, "width": 800.0}})
    read = load_camera_map(tmp_path / "c.mat", zoom=.5)
    theirs = load_camera_map(write(tmp_path / "calib_results.txt"), zoom=.5)
    np.testing.assert_allclose(read.distort(.7, -.4), theirs.distort(.7, -.4), atol=1e-9)
    with pytest.raises(InputError, match="camera 1 is asked for, the file holds one"):
        load_camera_map(tmp_path / "c.mat", camera="1")


@pytest.mark.parametrize("change,message", [
    ({"direct": [-x for x in DIRECT]}, "first coefficient of the polynomial is 260, OCamCalib's"),
    ({"centre": (1, 2, 3)}, "the centre has 3 numbers, 2 are needed"),
    ({"affine": (1, 0)}, "the list c d e has 2 numbers, 3 are needed"),
    ({"affine": (1, 0, float("nan"))}, "the list c d e holds a number that is not finite"),
    ({"size": (600.5, 800)}, "the image height is 600.5, a whole number"),
    ({"back": 1.05 * inverse()}, "the two polynomials differ by 15 px, 5 px are the limit"),
    ({"direct": DIRECT + [0.0] * 70}, "polynomial has 75 coefficients, the limit is 64"),
])
def test_bad_values_are_named(tmp_path, change, message):
    with pytest.raises(InputError, match=message):
        load_camera_map(write(tmp_path / "calib_results.txt", **change))


def test_lines_that_are_missing_or_wrong(tmp_path):
    path = tmp_path / "calib_results.txt"
    for old, new, message in (("5.0 -260.0", "4.0 -260.0", "has 5 coefficients, 4 are stated"),
                              ("600.0 800.0", "", "with 4 lines of numbers, 5 are needed"),
                              ("291.5", "true", "a value of the wrong kind: .*'true'")):
        path.write_text(text().replace(old, new))
        with pytest.raises(InputError, match=message):
            load_camera_map(path)


def test_polynomials_that_differ_a_little_are_warned_of(tmp_path):
    read = load_camera_map(write(tmp_path / "calib_results.txt", back=1.002 * inverse()), zoom=.5)
    assert "the two polynomials differ by 0.60 px, the direct one is taken" in read.warnings
