"""The tan-sigmoid in the descriptor: variant, bits and gamma of equation (17)."""

from dataclasses import replace

import numpy as np
import pytest
from amaranth.hdl import Fragment

from cameras import barrel_descriptor
from commands import call
from lenses import lens
from ncdc.cli import train
from ncdc_hdl.frontend.backmap import BackMap
from ncdc_hdl.lib.credits import CreditQueue
from ncdc_model.golden.network import frame_coordinates
from ncdc_sim.system.corrector import simulate_correction
from ncdc_spec.descriptor import Descriptor, Formats
from ncdc_spec.errors import InputError
from ncdc_spec.tansig import FRACTION_BITS, VARIANTS, choose_variant, design_for

D = barrel_descriptor()


def requantised(network=D.network, formats=Formats(), **about):
    return Descriptor.quantise(network, D.geometry, D.valid, formats, **about)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("bits", FRACTION_BITS)
def test_any_tansig_survives_the_file_and_stays_close(variant, bits, tmp_path):
    d = requantised(formats=Formats().with_tansig_bits(bits), variant=variant)
    d.save(tmp_path / "net.toml")
    loaded = Descriptor.load(tmp_path / "net.toml")
    assert loaded.tansig == design_for(variant, bits) and loaded.digest == d.digest
    a, b = frame_coordinates(loaded), frame_coordinates(D)
    # Two units of the tan-sigmoid through every output weight, and the coordinates' rounding.
    allowed = (2 * 2.0**-min(bits, 20) * np.abs(D.network.output_weights).sum(1) * 2**10 + 1)
    for k in range(2):
        assert np.abs(a[k] - b[k]).max() <= allowed[k]


def test_the_digest_distinguishes_variants():
    assert len({requantised(variant=variant).digest for variant in VARIANTS}) == len(VARIANTS)


@pytest.mark.parametrize("gamma", [.25, 8])
def test_gamma_of_a_power_of_two_changes_nothing_in_the_hardware(gamma, tmp_path):
    network = D.network.with_gamma(gamma)
    np.testing.assert_array_equal(network.hidden_weights * gamma, D.network.hidden_weights)
    d = requantised(network)
    d.save(tmp_path / "net.toml")
    loaded = Descriptor.load(tmp_path / "net.toml")
    assert loaded.network.gamma == gamma and loaded.digest == D.digest
    np.testing.assert_allclose(loaded.network(.3, -.2), D.network(.3, -.2), rtol=0, atol=1e-9)


def test_another_gamma_is_the_same_function_rounded():
    network = D.network.with_gamma(1.7)
    np.testing.assert_allclose(network(.3, -.2), D.network(.3, -.2), rtol=0, atol=1e-9)
    assert np.abs(requantised(network).hidden_weights - D.hidden_weights).max() <= 1


def test_gamma_scales_what_the_hardware_computes():
    d = requantised(replace(D.network, gamma=1.5))
    assert np.abs(d.hidden_weights - 1.5 * D.hidden_weights).max() <= 1.25


@pytest.mark.parametrize("old,new,message", [
    ("gamma = 1.0", "gamma = 0.0", "gamma is 0.0, a positive number is needed"),
    ("gamma = 1.0", 'gamma = "1"', "holds a value of the wrong kind"),
    ('variant = "mmhbc"', 'variant = "taylor"', "is 'taylor', one of mmhbc, classic, table"),
    ("fraction_bits = 20", "fraction_bits = 18", "has 18 fraction bits, its format Q1.21"),
    ("tansig = [1, 21]", "tansig = [2, 21]", "format is Q2.21, one integer bit is needed"),
])
def test_rejects(old, new, message, tmp_path):
    path = tmp_path / "net.toml"
    D.save(path)
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=message):
        Descriptor.load(path)


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("bits", [16, 22])
def test_the_front_end_has_space_for_every_variant(variant, bits):
    backmap = BackMap(1, Formats().with_tansig_bits(bits), variant=variant)
    Fragment.get(backmap, None)
    assert backmap.queue > backmap.latency + CreditQueue.loop


def test_auto_is_table_only_where_products_are_free():
    assert choose_variant("auto", 8) == "mmhbc"
    assert choose_variant("auto", 8, 15) == "mmhbc"
    assert choose_variant("auto", 8, 16) == "table"
    assert choose_variant("classic", 8, 16) == "classic"


@pytest.mark.longer
@pytest.mark.parametrize("variant,bits", [
    ("table", 16), pytest.param("classic", 22, marks=pytest.mark.regress),
    pytest.param("mmhbc", 18, marks=pytest.mark.regress)])
def test_the_correctors_verilog_equals_the_golden_model(variant, bits):
    d = requantised(formats=Formats().with_tansig_bits(bits), variant=variant)
    raw = np.random.default_rng(bits).integers(0, 256, d.geometry.distorted[::-1], np.uint8)
    result = simulate_correction(d, raw)
    assert len(result.differing) == 0


@pytest.mark.longer
def test_train_writes_the_chosen_tansig(tmp_path):
    lens().save(tmp_path / "camera.toml")
    call(train, tmp_path / "camera.toml", "--neurons", 2, "--size", "48x36", "-o",
         tmp_path / "net.toml", "--tansig", "table", "--tansig-bits", 16, "--gamma", 4)
    d = Descriptor.load(tmp_path / "net.toml")
    assert d.tansig == design_for("table", 16) and d.network.gamma == 4
    ratio = d.formats.hidden_weight.real(d.hidden_weights) / d.network.hidden_weights
    np.testing.assert_allclose(ratio, 4, rtol=1e-4)


def test_train_rejects_a_gamma_that_is_not_positive(tmp_path):
    lens().save(tmp_path / "camera.toml")
    with pytest.raises(InputError, match="gamma is -1.0, a positive number is needed"):
        call(train, tmp_path / "camera.toml", "--neurons", 2, "--gamma", -1)
