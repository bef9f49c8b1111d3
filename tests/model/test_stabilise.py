"""Gyroscopes: files, orientations as SciPy has them, and rows of a rolling shutter."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ncdc_model.evaluate import float_map
from ncdc_model.stabilise.gyro_file import load_gyroscope
from ncdc_model.stabilise.orientation import Gyroscope
from ncdc_model.stabilise.quaternions import matrices, mean, of_vectors, running_product
from ncdc_model.stabilise.stabiliser import Stabiliser
from ncdc_model.view_map import view_map
from ncdc_spec.errors import InputError
from ncdc_spec.view_matrix import Angles, PlaneCamera
from plane_lens import SIZE, seen_lens, shaking

HEAD = "time_s,x_rad_s,y_rad_s,z_rad_s"


def rates_of(rotations, seconds):
    """Body rates of SciPy ``rotations`` that are ``seconds`` apart, in the middle of each step."""
    return (rotations[:-1].inv() * rotations[1:]).as_rotvec() / seconds


def test_quaternions_are_scipys():
    vectors = np.random.default_rng(1).normal(0, 2, (30, 3))
    vectors[0] = 0
    own, theirs = of_vectors(vectors), Rotation.from_rotvec(vectors)
    np.testing.assert_allclose(matrices(own), theirs.as_matrix(), atol=1e-14)
    product = Rotation.identity()
    for k, found in enumerate(matrices(running_product(own))):
        product = product * theirs[k]
        np.testing.assert_allclose(found, product.as_matrix(), atol=1e-12)


def test_the_mean_is_scipys():
    near = Rotation.from_rotvec(np.random.default_rng(1).normal(1, .05, (30, 3)))
    weights = np.random.default_rng(2).uniform(0, 1, 30)
    signs = np.where(np.arange(30) % 3, 1, -1)[:, None]     # of a quaternion both are one rotation
    found = mean(signs * np.roll(near.as_quat(), 1, axis=1), weights)
    expected = near.mean(weights)
    assert (expected.inv() * Rotation.from_matrix(matrices(found))).magnitude() < 1e-9


def test_orientations_of_a_shaking_camera():
    fine = np.arange(0, 1, 1e-4)
    _, rotations = shaking(fine, 5)
    rates = rates_of(rotations, 1e-4)
    gyroscope = Gyroscope(fine[:-1:10] + .5e-4, rates[::10])
    times = np.array([.2, .50003, .9])
    found = Rotation.from_matrix(matrices(gyroscope.at(times)))
    expected = shaking(gyroscope.times[:1], 5)[1].inv() * shaking(times, 5)[1]
    assert (expected.inv() * found).magnitude().max() < 1e-4      # rad, of 0.09


def test_rates_between_samples_are_linear():
    gyroscope = Gyroscope(np.array([0., 1.]), np.array([[0., 0, 0], [0, 0, 2.]]))
    found = Rotation.from_matrix(matrices(gyroscope.at([.5, 1.]))).as_rotvec()
    np.testing.assert_allclose(found, [[0, 0, .25], [0, 0, 1]], atol=1e-12)


def test_smoothing_holds_a_shake_and_follows_a_turn():
    times = np.arange(0, 4, .002)
    shake = np.radians(3) * 2 * np.pi * 5 * np.cos(2 * np.pi * 5 * times)
    gyroscope = Gyroscope(times, np.stack([shake, np.full_like(times, .3), 0 * times], axis=1))
    vectors = Rotation.from_matrix(matrices(np.stack(
        [gyroscope.smooth(t, .3) for t in (1.5, 2, 2.5)]))).as_rotvec()
    np.testing.assert_allclose(np.diff(vectors[:, 1]), .15, atol=1e-3)
    assert np.abs(vectors[:, 0]).max() < 1e-3 < np.radians(3)
    np.testing.assert_array_equal(gyroscope.smooth(2, 0), gyroscope.at(2))


def test_smoothing_weighs_samples_by_their_time():
    times = np.concatenate([np.arange(0, 2, .0005), np.arange(2, 4, .005)])
    gyroscope = Gyroscope(times, np.tile([0, .3, 0], (len(times), 1)))
    vector = Rotation.from_matrix(matrices(gyroscope.smooth(2, .3))).as_rotvec()
    np.testing.assert_allclose(vector, [0, .6, 0], atol=1e-3)


@pytest.mark.parametrize("time", [-.1, 1.1])
def test_a_time_without_samples(time):
    gyroscope = Gyroscope(np.array([0., 1.]), np.zeros((2, 3)))
    with pytest.raises(InputError, match="samples are from 0 s to 1 s"):
        gyroscope.at(time)


@pytest.mark.parametrize("smoothing", [0, .2])
def test_each_raw_row_has_its_own_moment(smoothing):
    lens, readout, begin = seen_lens(), .016, .3
    fine = np.arange(0, 1, 1e-4)
    _, rotations = shaking(fine, 3)
    gyroscope = Gyroscope(fine[:-1] + .5e-4, rates_of(rotations, 1e-4))
    trained, angles = PlaneCamera.of(lens), Angles(pan=5, roll=-3, zoom=1.5)
    view = trained.view((80, 56), angles.zoom)
    stabiliser = Stabiliser(gyroscope, trained, view, angles.rotation, SIZE[1], readout, .1,
                            smoothing)
    *maps, blank = view_map(lens, (80, 56), stabiliser.matrices(begin))
    mean_turn = (shaking(gyroscope.times[:1], 3)[1] * Rotation.from_matrix(
        matrices(gyroscope.smooth(begin + .1 + readout / 2, smoothing)))).as_matrix()[0]
    back_map, compared = float_map(lens.exact_network, lens.geometry), 0
    for v, u in np.random.default_rng(3).integers(0, (56, 80), (60, 2)):
        ray = mean_turn @ angles.rotation @ np.linalg.inv(view.matrix) @ (u, v, 1)
        row = SIZE[1] / 2
        for _ in range(20):
            now = shaking([begin + .1 + readout * row / SIZE[1]], 3)[1].as_matrix()[0]
            x, y, depth = trained.matrix @ now.T @ ray
            column, row = back_map(x / depth, y / depth)
        if not blank[v, u]:
            compared += 1
            assert np.hypot(maps[0][v, u] - column, maps[1][v, u] - row) < .005
    assert compared > 30


def test_a_file(tmp_path):
    path = tmp_path / "gyro.csv"
    path.write_text(f"{HEAD}\n0,1,2,3\n\n.01, 4,5 ,6\n")
    gyroscope = load_gyroscope(path, "-y,x,z")
    np.testing.assert_array_equal(gyroscope.times, [0, .01])
    np.testing.assert_array_equal(gyroscope.rates, [[-2, 1, 3], [-5, 4, 6]])


def test_a_file_in_degrees(tmp_path):
    path = tmp_path / "gyro.csv"
    path.write_text("time_s,x_deg_s,y_deg_s,z_deg_s\n0,180,-90,0\n.01,2000,0,0\n")
    np.testing.assert_allclose(load_gyroscope(path).rates[0], [np.pi, -np.pi / 2, 0])
    path.write_text("time_s,x_deg_s,y_deg_s,z_deg_s\n0,0,0,0\n.01,0,2100,0\n")
    with pytest.raises(InputError, match="36.6519 rad/s, 35 is the limit"):
        load_gyroscope(path)


@pytest.mark.parametrize("lines,words", [
    (["time_s,x_deg_s,y_rad_s,z_rad_s", "0,0,0,0"], "a line time_s,x_rad_s,.*, or time_s,x_deg_s"),
    ([], "begins with ''"), (["t,x,y,z", "0,0,0,0"], "begins with 't,x,y,z'"),
    ([HEAD, "0,0,0,0"], "holds 1 samples"), ([HEAD, "0,0,0,0", ".01,0,0"], "line 3 of"),
    ([HEAD, "0,0,0,0", ".01,0,0,inf"], "line 3 of"),
    ([HEAD, "0,0,0,0", ".02,0,0,0", ".01,0,0,0"], "the time 0.01 s .* follows 0.02 s"),
    ([HEAD, "0,0,0,0", "0,0,0,0"], "times must rise"),
    ([HEAD, "0,0,0,0", ".01,0,0,0", ".02,0,0,0", ".1,0,0,0"], "a gap of 0.08 s after 0.02 s"),
    ([HEAD, "0,0,0,0", "10,0,0,0"], "10 s apart, 0.1 s is the limit"),
    ([HEAD, "0,0,0,0", ".01,0,200,0"], "200 rad/s, 35 is the limit")])
def test_files_that_are_rejected(tmp_path, lines, words):
    path = tmp_path / "gyro.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(InputError, match=words):
        load_gyroscope(path)


@pytest.mark.parametrize("axes", ["x,y", "x,y,w", "x,x,z", "-x,y,z", "y,x,z"])
def test_axes_that_are_rejected(tmp_path, axes):
    with pytest.raises(InputError, match="right-handed"):
        load_gyroscope(tmp_path / "none", axes)


@pytest.mark.parametrize("name,value", [("readout", .3), ("readout", -1e-3), ("smoothing", -1)])
def test_limits(name, value):
    trained = PlaneCamera(SIZE, 60.0, (46.5, 33.0))
    with pytest.raises(InputError, match=f"the {name} is .*, the limits are 0 and"):
        Stabiliser(Gyroscope(np.arange(2.), np.zeros((2, 3))), trained, trained, np.eye(3), 64,
                   **{name: value})
