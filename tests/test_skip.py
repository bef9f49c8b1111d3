"""The skip path: linear from the inputs to the outputs, from the descriptor to the coordinates."""

from dataclasses import replace

import numpy as np
import pytest
from cameras import barrel_descriptor

from ncdc_model.descriptor import Descriptor, Formats
from ncdc_model.errors import InputError
from ncdc_model.evaluate import evaluate_frame, fixed_map
from ncdc_model.fixed import Q
from ncdc_model.network import frame_coordinates, output_neuron

SKIP = np.array([[3.25, -41.5], [1000.0625, -7.75]])


def with_skip(d, weights=SKIP):
    """``d`` with a skip path of exactly ``weights`` pixels, which its output layer half undoes."""
    return Descriptor.quantise(replace(d.network, skip_weights=weights), d.geometry, d.valid)


@pytest.mark.parametrize("skip_weight", [Q(14, 12), Q(14, 8), Q(20, 12)])
def test_output_neuron_equals_exact_sum(skip_weight):
    """Against Python's integers of any size, with the finer products on either side."""
    f = replace(Formats(), skip_weight=skip_weight)
    rng = np.random.default_rng(skip_weight.f_bits)
    a = [rng.integers(f.tansig.lo, f.tansig.hi, 50) for _ in range(3)]
    inputs = [rng.integers(f.input.lo, f.input.hi, 50) for _ in range(2)]
    weights, skip = rng.integers(-2**20, 2**20, 3), rng.integers(-2**18, 2**18, 2)
    bias = int(rng.integers(-2**25, 2**25))
    got = output_neuron(a, weights, bias, f, inputs, skip)
    ulp = 2**60
    for k in range(50):
        total = bias * ulp >> f.output_bias.f_bits
        total += sum(int(w) * int(x[k]) * ulp >> (f.output_weight.f_bits + f.tansig.f_bits)
                     for w, x in zip(weights, a))
        total += sum(int(w) * int(x[k]) * ulp >> (skip_weight.f_bits + f.input.f_bits)
                     for w, x in zip(skip, inputs))
        exact = (total * 2**(f.coordinate.f_bits + 1) // ulp + 1) >> 1
        assert got[k] == min(max(exact, f.coordinate.lo), f.coordinate.hi)
    assert len(set(got.tolist())) > 40


def test_integers_follow_the_real_network():
    plain = barrel_descriptor((48, 40), (48, 40), hidden_neurons=4)
    d = with_skip(plain)
    assert evaluate_frame(d)["fixed_minus_float_max_px"] < .004
    x, y = d.geometry.normalise(*np.meshgrid(np.arange(48), np.arange(40)))
    for k, (raw, before) in enumerate(zip(frame_coordinates(d), frame_coordinates(plain))):
        moved = d.formats.coordinate.real(raw - before)
        np.testing.assert_allclose(moved, SKIP[k, 0] * x + SKIP[k, 1] * y, atol=.002)
    u, v = np.array([3, 17]), np.array([5, 30])
    np.testing.assert_array_equal(fixed_map(d)(u, v)[0],
                                  d.formats.coordinate.real(frame_coordinates(d)[0][v, u]))


def test_is_saved_loaded_and_part_of_the_digest(tmp_path):
    plain = barrel_descriptor()
    d = with_skip(plain)
    d.save(tmp_path / "net.toml")
    again = Descriptor.load(tmp_path / "net.toml")
    np.testing.assert_array_equal(again.skip_weights, np.round(SKIP * 2**12))
    np.testing.assert_array_equal(again.network.skip_weights, SKIP)
    assert again.formats == d.formats and again.digest == d.digest != plain.digest
    assert with_skip(plain, SKIP + 2**-12).digest != d.digest
    plain.save(tmp_path / "plain.toml")
    assert "skip" not in (tmp_path / "plain.toml").read_text()
    assert Descriptor.load(tmp_path / "plain.toml").skip_weights is None


@pytest.mark.parametrize("old,new,message", [
    ("skip_weight = [14, 12]", "", "skip_weights are needed in integers, in real numbers and"),
    ("skip_weight = [14, 12]", "skip_weight = [10, 12]",
     r"skip_weights holds 4096256 \(1000.06\), the limits of Q10.12 are"),
    ("skip_weight = [14, 12]", "skip_weight = [14, 31]", "the format skip_weight Q14.31 has 45 bits"),
    ("skip_weight = [14, 12]", "skip_weight = [4, 28]", "need 69 bits, the limit is 63"),
    ("[13312, -169984]", "[13312]", "net.toml"),
])
def test_bad_skip_paths_are_named(tmp_path, old, new, message):
    path = tmp_path / "net.toml"
    with_skip(barrel_descriptor()).save(path)
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message):
        Descriptor.load(path)
