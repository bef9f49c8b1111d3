"""Matrices of views: conventions, SciPy's rotations, OpenCV's perspective."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from cameras import barrel_descriptor
from ncdc_model.evaluate import float_map
from ncdc_model.view_map import plane_points, view_map
from ncdc_spec.errors import InputError
from ncdc_spec.view import CAMERA_FORMATS
from ncdc_spec.view_matrix import (
    LIMITS,
    Angles,
    PlaneCamera,
    camera_values,
    frame_of_values,
    view_matrix,
)
from plane_lens import SIZE, seen_lens

TRAINED = PlaneCamera(SIZE, 60.0, (46.5, 33.0), 1.1)


def matrix_of(size=None, trained=TRAINED, **angles):
    angles = Angles(**angles)
    return view_matrix(trained, trained.view(size, angles.zoom), angles.rotation)


def random_views(count):
    rng = np.random.default_rng(5)
    for _ in range(count):
        yield {name: rng.uniform(low / 4, high / 4) if name != "zoom" else rng.uniform(.5, 4)
               for name, (low, high) in LIMITS.items()}


def test_rotations_are_scipys():
    for view in random_views(20):
        expected = Rotation.from_euler("YXZ", [view["pan"], view["tilt"], view["roll"]],
                                       degrees=True).as_matrix()
        np.testing.assert_allclose(Angles(**view).rotation, expected, atol=1e-14)


def test_no_angle_is_the_trained_picture():
    np.testing.assert_allclose(matrix_of(), np.eye(3), atol=1e-15)


@pytest.mark.parametrize("angles,point", [
    ({"pan": 30}, (46.5 + 60 * np.tan(np.pi / 6), 33)),
    ({"tilt": 30}, (46.5, 33 - 66 * np.tan(np.pi / 6)))])
def test_where_the_axis_looks(angles, point):
    np.testing.assert_allclose(plane_points(matrix_of(**angles), 46.5, 33), point)


@pytest.mark.parametrize("angles,point", [
    ({"roll": 90}, (46.5, 33 + 1.1 * 10)), ({"zoom": 2}, (51.5, 33))])
def test_where_a_point_right_of_the_axis_looks(angles, point):
    np.testing.assert_allclose(plane_points(matrix_of(**angles), 56.5, 33), point)


def test_a_smaller_view_shows_as_much():
    corners = plane_points(matrix_of((48, 32)), np.array([-.5, 47.5]), np.array([-.5, 31.5]))
    np.testing.assert_allclose(corners, [(-.5, 95.5), (-.5, 63.5)])


def test_points_are_those_of_opencv():
    grid = np.stack(np.meshgrid(np.arange(96.), np.arange(64.)), axis=-1)
    for view in random_views(20):
        matrix = matrix_of(**view)
        expected = cv2.perspectiveTransform(grid, matrix)
        found = np.stack(plane_points(matrix, *np.moveaxis(grid, -1, 0)), axis=-1)
        in_front = np.isfinite(found[..., 0])
        assert (in_front == (grid @ matrix[2, :2] + matrix[2, 2] > 0)).all()
        np.testing.assert_allclose(found[in_front], expected[in_front], rtol=1e-9, atol=1e-6)


def test_the_map_is_opencvs_warp_of_the_trained_map():
    lens = seen_lens()
    trained = PlaneCamera.of(lens)
    u, v = np.meshgrid(np.arange(96.), np.arange(64.))
    whole = float_map(lens.exact_network, lens.geometry)(u, v)
    # Two pixels inside, so that all that OpenCV interpolates between is valid.
    valid = lens.valid.mask(96) & (lens.geometry.inside_by(*whole) >= -1)
    valid = cv2.erode(valid.astype(np.uint8), np.ones((5, 5)), borderValue=0,
                      borderType=cv2.BORDER_CONSTANT)
    compared = 0
    for view in random_views(10):
        matrix = matrix_of((80, 56), trained, **view)
        *maps, blank = view_map(lens, (80, 56), matrix)
        flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
        inside = cv2.warpPerspective(valid, matrix, (80, 56), flags=cv2.WARP_INVERSE_MAP) > 0
        inside &= matrix[2, 0] * u[:56, :80] + matrix[2, 1] * v[:56, :80] + matrix[2, 2] > 0
        compared += inside.sum()
        assert not blank[inside].any()
        for found, part in zip(maps, whole):
            warped = cv2.warpPerspective(part, matrix, (80, 56), flags=flags)
            # OpenCV rounds to a 32nd of a pixel, whose image is at most twice as large.
            assert np.abs(found - warped)[inside].max(initial=0) < 1 / 32
        assert (maps[0][blank] == -16).all()
    assert compared > 10_000


def test_pixels_without_a_source_are_blank():
    lens = seen_lens()
    valid, back_map = lens.valid.mask(96), float_map(lens.exact_network, lens.geometry)
    for view in random_views(30):
        matrix = matrix_of(None, PlaneCamera.of(lens), **view)
        blank = view_map(lens, SIZE, matrix)[2]
        for v, u in np.random.default_rng(2).integers(0, (64, 96), (40, 2)):
            x, y, depth = matrix @ (u, v, 1)
            x, y = (x / depth, y / depth) if depth > 0 else (-9, -9)
            column, row = round(x), round(y)
            seen = 0 <= column < 96 and 0 <= row < 64 and valid[row, column]
            seen = seen and lens.geometry.inside_by(*back_map(x, y)) >= -1
            assert blank[v, u] != seen


@pytest.mark.parametrize("name,value", [("pan", 91), ("tilt", -90.5), ("roll", 200),
                                        ("zoom", .1), ("zoom", 8.5), ("pan", float("nan"))])
def test_limits(name, value):
    with pytest.raises(InputError, match=f"{name} is .*, the limits are"):
        Angles(**{name: value})


def test_the_view_of_angles_is_that_of_their_matrix():
    view = TRAINED.looking(Angles(pan=20, tilt=-7, roll=30, zoom=2), (80, 56))
    matrix = matrix_of((80, 56), pan=20, tilt=-7, roll=30, zoom=2)
    assert view.size == (80, 56)
    np.testing.assert_allclose(view.real / view.real[2, 2], matrix / matrix[2, 2], atol=1e-4)
    far = PlaneCamera(SIZE, 9000.0, (46.5, 33.0))
    with pytest.raises(InputError, match="pan 90, tilt 0, roll 0, zoom 1 is too far off the axis"):
        far.looking(Angles(pan=90))


def test_a_descriptor_without_a_focal_length():
    with pytest.raises(InputError, match="does not state the focal length"):
        PlaneCamera.of(barrel_descriptor())


@pytest.mark.parametrize("frame", [[1234.567, -300.25, 541.0, 1.01], [0.5, 0, 0]])
def test_registers_hold_the_camera_of_a_picture(frame):
    values = camera_values(replace(seen_lens(), provenance={"frame": frame}))
    assert list(values) == list(CAMERA_FORMATS)
    assert frame_of_values(values) == pytest.approx([*frame, 1.0][:4], abs=2.0**-17)


@pytest.mark.parametrize("provenance", [
    {}, {"frame": [32768.0, 0, 0]}, {"frame": [2.0**-18, 0, 0]}, {"frame": [100, 16384.0, 0]},
    {"frame": [100, 0, 0, 2.0]}])
def test_a_camera_that_no_register_holds_is_not_known(provenance):
    values = camera_values(replace(seen_lens(), provenance=provenance))
    assert set(values.values()) == {0} and frame_of_values(values) is None


def test_a_camera_that_cannot_be_is_rejected():
    with pytest.raises(InputError, match="a focal length above 0"):
        camera_values(replace(seen_lens(), provenance={"frame": [-5.0, 0, 0]}))
