"""The skip path: linear from the inputs to the outputs, from the descriptor to the coordinates."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from front_end import FrontEnd, expected, extreme, frames
from ncdc_hdl.lib.pipeline import DelayMemory
from ncdc_hdl.neural.neuron import WeightedSum, output_sum
from ncdc_model.correction import correct
from ncdc_model.evaluate import evaluate_frame, fixed_map
from ncdc_model.golden.network import frame_coordinates, output_neuron
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.descriptor import Descriptor, Formats
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import registers
from pipelines import run_pipeline

SKIP = np.array([[3.25, -41.5], [1000.0625, -7.75]])


def with_skip(d, weights=SKIP):
    """``d`` with a skip path of exactly ``weights`` pixels, which its output layer half undoes."""
    return Descriptor.quantise(replace(d.network, skip_weights=weights), d.geometry, d.valid)


@pytest.mark.parametrize("skip_weight", [Q(14, 12), Q(14, 8), Q(20, 12)])
def test_output_neuron_equals_exact_sum(skip_weight):
    """Compared with Python's integers of any size, with the finer products on either side."""
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
    ("skip_weight = [14, 12]", "skip_weight = [14, 31]",
     "the format skip_weight Q14.31 has 45 bits"),
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


@pytest.mark.longer
@pytest.mark.parametrize("hidden,share,multiplier_bits,tansig_bits,lanes", [
    ("multiply", 3, 27, 20, 1), ("raster", 2, 18, 20, 1), ("multiply", 4, 18, 16, 1),
    *(pytest.param(*case, marks=pytest.mark.regress) for case in (
        ("multiply", 1, 27, 20, 1), ("raster", 1, 27, 20, 1), ("multiply", 1, 18, 16, 1),
        ("raster", 1, 27, 20, 2)))])
def test_front_end_equals_model(hidden, share, multiplier_bits, tansig_bits, lanes):
    """Frames with weights at the limits, then those of a map; stalls in between."""
    plain = barrel_descriptor((20, 16), (24, 18), hidden_neurons=4)
    formats = replace(Formats().with_tansig_bits(tansig_bits).with_skip(),
                      skip_weight=Q(12, 6) if tansig_bits == 16 else Q(14, 12))
    d = Descriptor.quantise(replace(plain.network, skip_weights=SKIP), plain.geometry, plain.valid,
                            formats)
    worst = [replace(extreme(d, seed), skip_weights=np.where(SKIP > 0, q.lo, q.hi))
             for seed, q in ((1, formats.skip_weight),)]
    dut = FrontEnd(d, hidden=hidden, share=share, multiplier_bits=multiplier_bits,
                   lanes=lanes)
    for frame, case in zip(frames(dut, [d, *worst], .3), [d, *worst]):
        np.testing.assert_array_equal(frame, expected(case, lanes=lanes))
    assert (expected(d)[:, :2] != expected(plain)[:, :2]).any(axis=0).all()


@pytest.mark.parametrize("field,change", [("skip_shift", 1), ("product_shift", 1)])
def test_finds_a_wrong_alignment(field, change, monkeypatch):
    right = getattr(WeightedSum, field).fget

    def wrong(q):
        return right(q) + change * (q.skip is not None)
    monkeypatch.setattr(WeightedSum, field, property(wrong))
    d = with_skip(barrel_descriptor((10, 9), (12, 10)))
    frame, = frames(FrontEnd(d), [d], 0)
    assert (frame != expected(d)).any()


@pytest.mark.parametrize("neurons", [1, 8, 32])
@pytest.mark.parametrize("skip_weight", [Q(14, 12), Q(14, 8)])
def test_no_weights_can_make_the_accumulator_wrap(neurons, skip_weight):
    q = output_sum(neurons, replace(Formats(), skip_weight=skip_weight))
    x, w = q.skip
    largest = (q.terms * q.xq.lo * q.wq.lo << q.product_shift) + (2 * x.lo * w.lo << q.skip_shift)
    largest += (q.bq.hi << q.bias_shift) + q.half
    limit = 1 << (q.shape.width - 1)
    assert limit // 2 <= largest < limit


@pytest.mark.parametrize("clocks", [2, 3, 43])
def test_delay_memory(clocks):
    dut, rng = DelayMemory(9, clocks), np.random.default_rng(clocks)
    dut.latency = clocks
    items = rng.integers(0, 512, 150).tolist()
    got = run_pipeline(dut, items, lambda ctx, item: ctx.set(dut.i, item), lambda: [dut.o])
    np.testing.assert_array_equal(np.ravel(got), items)
    with pytest.raises(ValueError, match="clocks is 1, a memory delays by at least 2"):
        DelayMemory(9, 1)


def test_registers():
    plain = barrel_descriptor()
    d = with_skip(plain)
    table = registers(3, d.formats)
    added = [r for r in table if r not in registers(3, plain.formats)]
    assert [r.name for r in added] == [f"SKIP_{k}_WEIGHT_{j}" for k in "XY" for j in "XY"]
    assert len({r.address for r in table}) == len(table)
    values = host_values(d)
    assert [values[r.name] for r in added] == np.ravel(d.skip_weights).tolist()
    assert all(r.access == "shadow" and r.shape.width == 26 and r.shape.signed for r in added)


@pytest.mark.longer
@pytest.mark.parametrize("simulator", [
    "verilator", pytest.param("icarus", marks=pytest.mark.regress)])
def test_verilog_corrects_a_frame_with_it(simulator):
    d = with_skip(barrel_descriptor((40, 32), (44, 36)), SKIP / 100)
    raw = np.random.default_rng(1).integers(0, 256, d.geometry.distorted[::-1], np.uint8)
    result = simulate_correction(d, raw, simulator=simulator)
    assert not len(result.differing)
    plain = correct(barrel_descriptor((40, 32), (44, 36)), raw)
    assert (result.picture != plain.picture).any(axis=2).mean() > .3
