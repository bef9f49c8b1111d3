"""Errors in pixels: the measure itself, float and fixed point, points and whole frames."""

import dataclasses

import numpy as np
import pytest

from lenses import GEOMETRY, equidistant, known_network
from ncdc_model.evaluate import evaluate_frame, evaluate_points, fixed_map, float_map, map_error
from ncdc_model.golden.network import coordinates
from ncdc_model.golden.valid import valid_rows
from ncdc_spec.descriptor import Descriptor, FloatNetwork
from ncdc_spec.geometry import ValidRows


def descriptor(network=None, back_map=None):
    network = network or known_network()
    valid = valid_rows(back_map or float_map(network, GEOMETRY), GEOMETRY)
    return Descriptor.quantise(network, GEOMETRY, valid)


def test_map_error_by_hand():
    zero = np.zeros(4)
    x, y = np.array([3.0, 0, 1, 0]), np.array([4.0, 0, 0, 2])
    assert map_error((x, y), (zero, zero)) == {"mse": 7.5, "mean": 2.0, "max": 5.0}
    mask = np.array([False, True, True, True])
    assert map_error((x, y), (zero, zero), mask) == {"mse": 5 / 3, "mean": 1.0, "max": 2.0}
    assert np.isnan(map_error((x, y), (zero, zero), ~mask & mask)["mse"])


def test_fixed_map_equals_the_integer_network_at_every_pixel():
    d = descriptor()
    v, u = np.indices((240, 320))
    for real, raw in zip(fixed_map(d)(u, v), coordinates(d, u, v)):
        np.testing.assert_array_equal(real, d.formats.coordinate.real(raw))


def test_fixed_point_costs_less_than_three_thousandths_of_a_pixel():
    report = evaluate_frame(descriptor())
    assert 2**-11 < report["fixed_minus_float_max_px"] < .003
    assert "map_error_fixed_px" not in report


def test_frame_compared_with_the_truth_takes_valid_pixels_only():
    network = known_network()
    shifted = dataclasses.replace(network, output_biases=network.output_biases + [.3, -.4])
    d, maps = descriptor(shifted, lambda u, v: (u - 20, v)), {}
    report = evaluate_frame(d, float_map(network, GEOMETRY), maps)
    assert report["hidden_neurons"] == 3
    valid = d.valid.mask(320)
    assert report["valid_pixels"] == valid.sum() < valid.size
    assert report["map_error_float_px"] == pytest.approx({"mse": .25, "mean": .5, "max": .5})
    assert report["map_error_fixed_px"]["max"] == pytest.approx(.5, abs=.003)
    assert report["map_error_fixed_px"]["max"] > .5
    assert np.isnan(maps["fixed"][~valid]).all()
    assert np.nanmax(maps["fixed"]) == pytest.approx(report["map_error_fixed_px"]["max"], rel=1e-6)


def test_pixels_whose_truth_is_unknown_do_not_count():
    network = known_network()
    d = Descriptor.quantise(network, GEOMETRY, ValidRows.everything(320, 240))

    def partly(u, v):
        x, y = network(*GEOMETRY.normalise(u, v))
        return np.where(u < 100, np.nan, x), np.where(u < 100, 0.0, y)
    errors = evaluate_frame(d, partly)["map_error_float_px"]
    assert max(errors.values()) < 1e-9 and min(errors.values()) == 0


def test_points_outside_the_frame_do_not_count():
    d = descriptor()
    u, v = np.array([10.25, 400.0, 300.5, 20.0]), np.array([20.75, 50.0, 200.0, -3.0])
    x, y = known_network()(*GEOMETRY.normalise(u, v))
    report = evaluate_points(d, u, v, x + [1, 100, 0, 100], y)
    assert report["points"] == 2
    assert report["map_error_float_px"]["mse"] == pytest.approx(.5)
    assert report["map_error_fixed_px"]["max"] == pytest.approx(1, abs=.003)


def test_a_wrong_network_is_seen():
    network = known_network()
    worse = FloatNetwork(network.hidden_weights, network.hidden_biases,
                         network.output_weights * 1.01, network.output_biases)
    errors = evaluate_frame(descriptor(worse, equidistant), float_map(network, GEOMETRY))
    assert errors["map_error_float_px"]["max"] > .5
