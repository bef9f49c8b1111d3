"""The baselines: each recovers a lens of its own kind from exact points."""

import numpy as np
import pytest
from scipy.interpolate import BSpline
from scipy.spatial.transform import Rotation

from ncdc_bench.baselines import BASELINES
from ncdc_bench.baselines.mesh import fit_bicubic_mesh
from ncdc_bench.baselines.polyharmonic import fit_polyharmonic
from ncdc_bench.reference_lenses import ReferenceLens
from ncdc_model.evaluate import map_error
from ncdc_model.lens import AsariPolynomial
from ncdc_model.training.problem import Problem
from ncdc_spec.geometry import Geometry

GEOMETRY = Geometry(640, 480, 640, 480)
CENTRES = {"shared": ((322, 236), (322, 236)), "separate": ((322, 236), (309, 251))}
K = (-.21, .06, .0011, -.0008, -.009, .05, -.01, .002, .0015, -.0006, -.0012, .0004, .012, -.019)
FISHEYE = (.035, .012, -.004, .001)


def seen(lens, columns=31, rows=21):
    """Exact points of ``lens`` on a grid over the frame."""
    u, v = np.meshgrid(np.linspace(8, 631, columns), np.linspace(8, 471, rows))
    return Problem(u, v, *lens(u, v), GEOMETRY)


def largest_error(name, lens):
    """Largest error of the baseline ``name``, fitted to exact points of ``lens``, at any pixel."""
    u, v = np.meshgrid(np.linspace(0, 639, 90), np.linspace(0, 479, 70))
    return map_error(BASELINES[name](seen(lens))(u, v), lens(u, v))["max"]


def asari(kind, order):
    """A radial polynomial about the centres of ``kind``."""
    a = (0, 1.1, -.02, -.08, .01, .004, -.002, 3e-4, -1e-4)
    radial = AsariPolynomial(a[:order + 1], limit=2)
    (u0, v0), (x0, y0) = CENTRES[kind]

    def lens(u, v):
        x, y = radial.distort((u - u0) / 320, (v - v0) / 320)
        return x0 + 320 * x, y0 + 320 * y
    return lens


def posed(distort):
    """A lens model (a, b) to (x, y) before which the picture stands at a small angle."""
    turn = Rotation.from_rotvec([.02, -.03, .01]).as_matrix()

    def lens(u, v):
        at = np.stack([(u - 319.5) / 320, (v - 239.5) / 320, np.zeros_like(u)])
        a, b, w = np.tensordot(turn, at, 1) + np.array([.02, -.01, .95])[:, None, None]
        x, y = distort(a / w, b / w)
        return 331 * x + 322, 329 * y + 236
    return lens


def pinhole(count):
    """OpenCV's pinhole model with the first ``count`` of the coefficients K."""
    k1, k2, p1, p2, k3, k4, k5, k6, s1, s2, s3, s4, tx, ty = (*K[:count], *[0] * (14 - count))
    cx, sx, cy, sy = np.cos(tx), np.sin(tx), np.cos(ty), np.sin(ty)
    turn = (np.array([[cy, 0, -sy], [0, 1, 0], [sy, 0, cy]])
            @ np.array([[1, 0, 0], [0, cx, sx], [0, -sx, cx]]))
    tilt = np.array([[turn[2, 2], 0, -turn[0, 2]], [0, turn[2, 2], -turn[1, 2]], [0, 0, 1]]) @ turn

    def distort(a, b):
        q = a * a + b * b
        radial = (1 + k1 * q + k2 * q**2 + k3 * q**3) / (1 + k4 * q + k5 * q**2 + k6 * q**3)
        x = a * radial + 2 * p1 * a * b + p2 * (q + 2 * a * a) + s1 * q + s2 * q * q
        y = b * radial + p1 * (q + 2 * b * b) + 2 * p2 * a * b + s3 * q + s4 * q * q
        x, y, w = np.tensordot(tilt, np.stack([x, y, np.ones_like(x)]), 1)
        return x / w, y / w
    return distort


def fisheye(a, b):
    r = np.hypot(a, b)
    t = np.arctan(r)
    ratio = t * np.polynomial.polynomial.polyval(t * t, (1, *FISHEYE)) / np.maximum(r, 1e-12)
    return a * ratio, b * ratio


@pytest.mark.parametrize("order", [6, 7, 8])
@pytest.mark.parametrize("kind", ["shared", "separate"])
def test_asari_polynomial(kind, order):
    # Rounding of the linear solution, 600 pixels times 2^-53 times a condition of about 1e4.
    assert largest_error(f"pbm{order}-{kind}", asari(kind, order)) < 1e-9


def test_one_centre_does_not_fit_two():
    assert largest_error("pbm8-shared", asari("separate", 6)) > 1


@pytest.mark.parametrize("name, lens", [
    ("brown5", posed(pinhole(5))), ("opencv-full", posed(pinhole(14))),
    ("opencv-fisheye", posed(fisheye))], ids=["brown5", "opencv-full", "opencv-fisheye"])
def test_models_of_opencv(name, lens):
    # Gauss-Newton's steps square a small error, so that on exact points rounding is left.
    assert largest_error(name, lens) < 1e-8


def test_smaller_model_does_not_fit_the_larger_lens():
    assert largest_error("brown5", posed(pinhole(14))) > .02


def cubic(u, v):
    a, b = (u - 300) / 320, (v - 250) / 320
    return 320 + 290 * a - 30 * a**3 + 12 * a * b * b + 5 * b * b, 240 + 280 * b - 20 * a * a * b


def test_bilinear_mesh():
    # Polynomials below order 4 pass the spline; bilinear interpolation leaves at most
    # step^2 / 8 times the sum of the largest second derivatives, here on each axis.
    span = 340 / 320
    bound = 8**2 / 8 / 320**2 * np.array([6 * 30 * span + 24 * span + 10, 40 * 250 / 320])
    error = largest_error("mesh8-bilinear", cubic)
    assert .2 * np.hypot(*bound) < error < np.hypot(*bound) + 1e-6


def test_polyharmonic_spline_keeps_polynomials_and_takes_noise_away():
    u, v = np.meshgrid(np.linspace(0, 639, 50), np.linspace(0, 479, 40))
    exact = seen(cubic)
    np.testing.assert_allclose(fit_polyharmonic(exact)(u, v), cubic(u, v), atol=1e-6)
    noise = np.random.default_rng(2).normal(0, .05, (2, len(exact)))
    noisy = Problem(exact.u, exact.v, exact.x + noise[0], exact.y + noise[1], GEOMETRY)
    error = map_error(fit_polyharmonic(noisy)(u, v), cubic(u, v))
    # 10 free numbers of 651 per axis remain, and their share of the noise; little more.
    assert error["mse"] < 2.5 * 2 * .05**2 * 10 / len(exact)


def test_bicubic_mesh():
    knots = [128 * np.arange(-3.0, count) for count in (9, 8)]
    random = np.random.default_rng(4)
    planes = random.normal(0, 3, (2, 7, 8)) + 60 * np.indices((7, 8))[::-1]

    def lens(u, v):
        across, down = (BSpline.design_matrix(np.ravel(at), knot, 3).toarray()
                        for at, knot in zip((u, v), knots))
        return tuple(((down @ plane) * across).sum(1).reshape(u.shape) for plane in planes)
    # The least penalty, 1e-10, times differences of about 300, over eigenvalues from 1e-3 on.
    assert largest_error("mesh128-bicubic", lens) < 1e-4


def test_bicubic_mesh_extends_where_no_point_is():
    exact = seen(cubic)
    part = fit_bicubic_mesh(exact.take(exact.u > 200), 128)
    u, v = np.meshgrid(np.linspace(0, 200, 20), np.linspace(0, 479, 20))
    assert 1e-3 < map_error(part(u, v), cubic(u, v))["max"] < 20


def test_figures_on_a_reference_lens():
    lens = ReferenceLens("120kb")
    dots, truth = lens.dots(), lens.truth(16)
    mse = {name: map_error(BASELINES[name](dots)(truth.u, truth.v), (truth.x, truth.y))["mse"]
           for name in ("pbm6-shared", "pbm8-shared", "pbm6-separate", "opencv-fisheye",
                        "mesh8-bilinear", "mesh128-bicubic")}
    # One centre: as bad as the paper's 88, whatever the order; two centres: 5 times better.
    assert mse["pbm6-shared"] == pytest.approx(79.4, rel=.02)
    assert mse["pbm8-shared"] == pytest.approx(mse["pbm6-shared"], rel=.01)
    assert mse["pbm6-separate"] == pytest.approx(14.1, rel=.02)
    assert mse["opencv-fisheye"] == pytest.approx(.80, rel=.05)
    assert mse["mesh8-bilinear"] < .0012 and mse["mesh128-bicubic"] < .002
