"""Camera models: inverses, equations, files, and the study's exact lenses."""

import cv2
import numpy as np
import pytest

from ncdc_model.example import example_camera
from ncdc_model.lens import (
    AsariPolynomial,
    AsymmetricSurface,
    BrownWeng,
    Camera,
    KannalaBrandt,
    Pinhole,
    Rational,
    TiltedSensor,
    rotation,
)
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import Geometry

GRID = np.meshgrid(np.linspace(-1.2, 1.2, 25), np.linspace(-0.9, 0.9, 19))

MODELS = {
    "pinhole": Pinhole(500, 490, 320, 240, skew=0.7),
    "asari": AsariPolynomial((0, 1.0, 0.02, -0.08, 0.01), centre=(0.05, -0.02), limit=2.0),
    "rational": Rational((0.30, 0.02, 0.001, 0.65, 0.08, 0.003)),
    "brown radial": Rational((-0.05, 0.004)),
    "equidistant": KannalaBrandt(),
    "kannala-brandt": KannalaBrandt((-0.02, 0.005, -0.002, 0.0007)),
    "brown-weng": BrownWeng(k=(-0.08, 0.01), p=(0.002, -0.001, 0.1),
                            s=(0.001, 0.0002, -0.0005, 0.0), centre=(0.02, -0.01)),
    "tilted": TiltedSensor((0.03, -0.02)),
}


@pytest.mark.parametrize("name", MODELS)
def test_undistort_inverts_distort(name):
    x, y = MODELS[name].distort(*GRID)
    a, b = MODELS[name].undistort(x, y)
    np.testing.assert_allclose([a, b], GRID, atol=1e-10)


def test_surface_inverse_in_pixels():
    surface = example_camera().surface
    u, v = np.meshgrid(np.arange(0, 640.0, 16), np.arange(0, 480.0, 16))
    x, y = surface.distort(u, v)
    assert 0.8 < np.hypot(x - u, y - v).max() < 2.0
    np.testing.assert_allclose(surface.undistort(x, y), (u, v), atol=1e-7)


def test_outside_the_domain_is_not_a_number():
    assert np.isnan(KannalaBrandt().undistort(1.58, 0.0)[0])        # beyond 90 degrees
    folded = Rational((-0.3,))                                      # rd stops growing at 1.054
    assert np.isnan(folded.distort(1.2, 0.0)[0])
    assert np.isnan(folded.undistort(0.8, 0.0)[0])
    assert np.isfinite(folded.distort(1.0, 0.0)[0])
    assert np.isnan(example_camera().project(np.array([0.0, 0.0, -1.0]))[0])


def test_asari_is_the_polynomial_of_the_radius():
    x, y = AsariPolynomial((0, 0.9, 0.1), centre=(1.0, 2.0)).distort(4.0, 6.0)
    # rho = 5: rho' = 0.9 * 5 + 0.1 * 25 = 7 in the direction (3, 4) / 5.
    np.testing.assert_allclose([x, y], [1 + 4.2, 2 + 5.6])


def test_brown_weng_is_opencv():
    k, p, s = (-0.11, 0.02), (0.004, -0.003), (0.001, -0.0005, 0.0007, 0.0002)
    x, y = BrownWeng(k=k, p=p, s=s).distort(*GRID)
    # OpenCV: k1 k2 p1 p2 k3 k4 k5 k6 s1 s2 s3 s4, with p1 and p2 the other way round.
    coefficients = np.array([*k, p[1], p[0], 0, 0, 0, 0, *s])
    points = np.stack([*GRID, np.ones_like(GRID[0])], axis=-1).reshape(-1, 1, 3)
    expected = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), coefficients)[0]
    np.testing.assert_allclose(np.stack([x, y], -1).reshape(-1, 1, 2), expected, atol=1e-12)


def test_tilted_sensor_is_opencv():
    coefficients = np.zeros(14)
    coefficients[12:] = 0.03, -0.02
    points = np.stack([*GRID, np.ones_like(GRID[0])], axis=-1).reshape(-1, 1, 3)
    expected = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), coefficients)[0]
    x, y = TiltedSensor((0.03, -0.02)).distort(*GRID)
    np.testing.assert_allclose(np.stack([x, y], -1).reshape(-1, 1, 2), expected, atol=1e-12)


def test_kannala_brandt_is_opencv_fisheye():
    k = (-0.02, 0.005, -0.002, 0.0007)
    points = np.stack(GRID, -1).reshape(-1, 1, 2)
    expected = cv2.fisheye.distortPoints(points, np.eye(3), np.array(k))
    x, y = KannalaBrandt(k).distort(*GRID)
    np.testing.assert_allclose(np.stack([x, y], -1).reshape(-1, 1, 2), expected, atol=1e-12)


def test_pinhole_projects_world_points():
    camera, turn = Pinhole(500, 480, 320, 240), rotation(0.1, -0.2, 0.3)
    point, shift = np.array([0.3, -0.2, 4.0]), np.array([0.1, 0.2, 0.3])
    u, v, w = camera.matrix @ (turn @ point + shift)
    np.testing.assert_allclose(camera.project(point, turn, shift), (u / w, v / w))
    np.testing.assert_allclose(turn @ turn.T, np.eye(3), atol=1e-15)
    assert np.isnan(camera.project(np.array([0.0, 0.0, -1.0]))).all()


def test_ray_and_project_are_inverse():
    camera = example_camera()
    x, y = np.meshgrid(np.linspace(0, 639, 17), np.linspace(0, 479, 13))
    np.testing.assert_allclose(camera.project(3.0 * camera.ray(x, y)), (x, y), atol=1e-8)


def test_camera_file_round_trip(tmp_path):
    camera = example_camera().framed((320, 240), 0.5)
    camera.save(tmp_path / "camera.toml")
    assert Camera.load(tmp_path / "camera.toml") == camera


@pytest.mark.parametrize("line,error", [
    ("width = 640", "lacks the value 'width'"),
    ("f_distorted = 338.0", "lacks the value 'f_distorted'"),
])
def test_camera_file_without_a_value(tmp_path, line, error):
    path = tmp_path / "camera.toml"
    example_camera().save(path)
    text = path.read_text()
    assert line in text
    path.write_text(text.replace(line, ""))
    with pytest.raises(InputError, match=error):
        Camera.load(path)


@pytest.mark.parametrize("change,error", [
    ({"width": 5}, "width is 5, a whole number of 8 to 4096 is needed"),
    ({"f_distorted": -3.0}, "f_distorted is -3, it must be positive"),
    ({"radial": "magic"}, "radial model is 'magic', one of kb, brown, asari is needed"),
    ({"centre": [1.0, float("nan")]}, "centre holds nan"),
    ({"centre": [1.0]}, "centre is .*, 2 numbers are needed"),
    ({"k": "none"}, "k holds .none., a number is needed"),
])
def test_camera_rejects_bad_values(change, error):
    with pytest.raises(InputError, match=error):
        Camera.from_dict({**example_camera().to_dict(), **change})


def test_zoom_fit_fills_the_width():
    camera = example_camera().framed((800, 600), "fit")
    u, _ = camera.corrected(np.array([0.0, 639.0]), np.array([239.5, 239.5]))
    np.testing.assert_allclose(u, (0, 799), atol=1e-6)


def test_zoom_fill_has_a_source_everywhere_and_no_smaller_zoom_has():
    camera = example_camera().framed((320, 240), "fill")
    geometry = Geometry(320, 240, 640, 480)

    def whole(frame_of):
        u, v = np.meshgrid(np.arange(320), np.arange(240))
        return geometry.window_inside(*frame_of.back_map(u, v)).all()
    assert whole(camera)
    magnified = camera.frame.focal / np.linalg.det(_jacobian(camera))**0.5
    assert not whole(camera.framed((320, 240), 0.999 * magnified))


def _jacobian(camera, h=1e-4):
    """Distorted pixels per unit of the ideal plane at the middle of the corrected frame."""
    a, b = camera.frame.ideal(*((np.array(camera.frame.size) - 1) / 2))
    right, left = camera.distort(a + h, b), camera.distort(a - h, b)
    below, above = camera.distort(a, b + h), camera.distort(a, b - h)
    return np.column_stack([np.subtract(right, left), np.subtract(below, above)]) / (2 * h)


def test_zoom_number_is_the_magnification_in_the_middle():
    camera = example_camera().framed(zoom=0.8)
    u, v = (np.array(camera.frame.size) - 1) / 2
    x, y = camera.back_map(u + np.array([0, 1, 0]), v + np.array([0, 0, 1]))
    area = abs((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]))
    assert area == pytest.approx(1 / 0.8**2, rel=0.01)


@pytest.mark.parametrize("zoom", ["wide", -1, 0, "nan", 1e6])
def test_zoom_that_is_none(zoom):
    with pytest.raises(InputError, match="fit, fill or a number of 0.01..100 is needed"):
        example_camera().framed(zoom=zoom)


def test_zoom_fit_of_a_lens_that_sees_more_than_a_hemisphere():
    table = {"width": 640, "height": 480, "f_distorted": 180.0, "centre": [320, 240]}
    with pytest.raises(InputError, match="90 degrees or more"):
        Camera.from_dict(table)
    assert np.isfinite(Camera.from_dict({**table, "f_corrected": 100.0}).back_map(0.0, 0.0)).all()


def test_surface_of_no_scale_is_the_identity():
    np.testing.assert_array_equal(AsymmetricSurface((64, 48)).distort(*GRID), GRID)
