"""Rounding all numbers of a network together: closer to it than rounding each to nearest."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.evaluate import evaluate_frame, float_map
from ncdc_model.golden.network import frame_coordinates
from ncdc_model.training.rounding import fitted_formats, round_network
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.descriptor import Descriptor, Formats
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.geometry import ValidRows
from ncdc_spec.hardware import Hardware


def errors(d):
    """rms and largest difference on an axis of the integers of ``d`` from its float network."""
    v, u = np.indices(d.geometry.corrected[::-1])
    real = np.stack(float_map(d.network, d.geometry)(u, v))
    e = (d.formats.coordinate.real(frame_coordinates(d)) - real)[:, d.valid.mask(u.shape[1])]
    return np.sqrt((e**2).mean()), np.abs(e).max()


def lens(seed=1, skip=False, distorted=(1920, 1536)):
    """A network whose output weights are hundreds of pixels, and its geometry and valid rows."""
    d = barrel_descriptor((96, 80), distorted, hidden_neurons=6, seed=seed)
    network = d.network
    if skip:
        network = replace(network, skip_weights=np.array([[301.77, -4.4], [8.123, 250.5]]))
    return network, d.geometry, d.valid


@pytest.mark.parametrize("skip", [False, True])
@pytest.mark.parametrize("tansig_bits,share,limit", [(20, .7, .012), (16, 1, .03)])
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_18_bits_are_nearly_as_good_as_24(seed, tansig_bits, share, limit, skip):
    network, *about = lens(seed=seed, skip=skip)
    formats = fitted_formats(network, Formats(), 18).with_tansig_bits(tansig_bits)
    assert {q.width for name, q in formats.items() if "weight" in name or name == "input"} == {18}
    nearest = errors(Descriptor.quantise(network, *about, formats))
    together = errors(round_network(network, *about, formats))
    assert together[0] < share * nearest[0] and together[1] < limit


@pytest.mark.parametrize("bits,limit", [(10, .0022), (8, .0035)])
@pytest.mark.parametrize("gamma", [1, 3])
def test_24_bits_add_little_more_than_the_coordinates_last_bit(bits, limit, gamma):
    network, *about = lens(distorted=(640, 512))
    formats = replace(Formats(), coordinate=Q(14, bits))
    d = round_network(network.with_gamma(gamma), *about, formats, variant="table")
    assert d.variant == "table" and d.network.gamma == gamma
    assert errors(d)[1] <= limit
    assert evaluate_frame(d)["fixed_minus_float_max_px"] == pytest.approx(errors(d)[1])


def test_formats_fit_the_network():
    network, *_ = lens()
    network = replace(network, hidden_weights=np.array([[3.99, -.1], [.2, .3]]),
                      output_weights=np.array([[-511.0, 1], [2, 3]]))
    formats = fitted_formats(network, Formats(), 18)
    assert formats.hidden_weight == Q(3, 15) and formats.output_weight == Q(10, 8)
    assert fitted_formats(network.with_gamma(2), Formats(), 20).hidden_weight == Q(3, 17)
    edge = replace(network, hidden_weights=np.array([[4 - 2.0**-17, 0], [0, 1]]))
    assert fitted_formats(edge, Formats(), 18).hidden_weight == Q(4, 14)
    with pytest.raises(InputError, match="weights shall have 17 bits, the limits are 18 and 24"):
        fitted_formats(network, Formats(), 17)


def test_nothing_valid_is_rounded_to_nearest():
    network, geometry, _ = lens()
    rows = ValidRows(np.zeros((80, 4), int))
    d = round_network(network, geometry, rows, Formats())
    assert d.digest == Descriptor.quantise(network, geometry, rows).digest


def test_weights_at_the_limit_stay_within_it():
    network, *about = lens()
    limit = 8 - 2.0**-18
    steep = replace(network, hidden_weights=np.clip(network.hidden_weights * 99, -limit, limit))
    raw = round_network(steep, *about, Formats()).hidden_weights
    assert Q(4, 20).holds(raw) and Q(4, 20).hi in raw


@pytest.mark.longer
@pytest.mark.parametrize("hidden", [
    pytest.param("multiply", marks=pytest.mark.regress), "raster"])
def test_verilog_takes_formats_of_few_bits(hidden):
    """No factor above 18 bits, 8 fraction bits of the coordinates, multiplier blocks of 18 bits."""
    d = barrel_descriptor((40, 32), (44, 36))
    formats = fitted_formats(d.network, replace(Formats(), coordinate=Q(14, 8)), 18)
    few = round_network(d.network, d.geometry, d.valid, formats.with_tansig_bits(16))
    assert max(q.width for name, q in few.formats.items()
               if name in ("input", "hidden_weight", "tansig", "output_weight")) == 18
    raw = np.random.default_rng(1).integers(0, 256, (36, 44), np.uint8)
    result = simulate_correction(few, raw, Hardware(hidden=hidden, multiplier_bits=18))
    assert result.differing == [] and not result.blank.all()
