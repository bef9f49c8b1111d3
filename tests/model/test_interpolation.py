"""Interpolation by windows of 6x6 samples, and what a descriptor says of it."""

from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.golden.corrector import correct
from ncdc_model.golden.directional import directional_colours, twice_direction
from ncdc_model.golden.network import coordinates
from ncdc_model.golden.picture import (
    bilinear,
    corner_colours,
    gradient_colours,
    raw_windows,
    window_address,
)
from ncdc_model.images import mosaic
from ncdc_model.reference import correct_real, grey_level_difference
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.geometry import BAYER_PHASE, BAYERS, MONO, Geometry
from ncdc_spec.hardware import Hardware
from ncdc_spec.interpolation import DIRECTIONAL, FAST, GRADIENT
from ncdc_spec.registers.host_values import host_values
from ncdc_spec.registers.register_map import BAYER_MONO, INTERPOLATION_BITS, capabilities

DECODERS = {GRADIENT: gradient_colours, DIRECTIONAL: directional_colours}
both = pytest.mark.parametrize("needs", DECODERS, ids=lambda each: each.name)


def gradient_descriptor(needs=GRADIENT, **geometry):
    return barrel_descriptor((48, 40), (64, 48), interpolation=needs, **geometry)


@both
@pytest.mark.parametrize("bayer", BAYERS)
def test_integers_are_the_floating_point_picture_rounded(needs, bayer):
    d = gradient_descriptor(needs, bayer=bayer)
    raw = np.random.default_rng(1).integers(0, 256, (48, 64), np.uint8)
    result = correct(d, raw)
    v, u = np.indices(d.geometry.corrected[::-1])
    at = [d.formats.coordinate.real(value) for value in coordinates(d, u, v)]
    real = correct_real(d, raw, at=at)
    assert grey_level_difference(result.picture, real) <= 1
    # Noise drives the kernels beyond both ends, where the result is clamped; grey has no kernel.
    assert ({0, 255} <= set(result.picture[~result.blank].ravel().tolist())) == (bayer != MONO)
    assert result.blank.any() and not result.blank.all()


@pytest.mark.parametrize("crest", [1, 2])
@pytest.mark.parametrize("bayer", BAYERS)
def test_integers_with_crests_are_the_floating_point_picture_rounded(bayer, crest):
    d = gradient_descriptor(DIRECTIONAL, bayer=bayer)
    raw = np.random.default_rng(1).integers(0, 256, (48, 64), np.uint8)
    v, u = np.indices(d.geometry.corrected[::-1])
    at = [d.formats.coordinate.real(value) for value in coordinates(d, u, v)]
    made = correct(d, raw, crest=crest).picture
    assert grey_level_difference(made, correct_real(d, raw, at=at, crest=crest)) <= 1
    for other in {0, 1, 2} - {crest}:
        assert grey_level_difference(made, correct_real(d, raw, at=at, crest=other)) > 8


@both
@pytest.mark.parametrize("bayer", BAYER_PHASE)
def test_a_flat_colour_stays_that_colour_up_to_every_edge(needs, bayer):
    colour = np.broadcast_to(np.uint8([201, 90, 17]), (10, 12, 3))
    windows = raw_windows(mosaic(colour, bayer), GRADIENT)
    y0, x0 = np.indices((9, 11))
    corners = DECODERS[needs](windows[y0, x0], x0, y0, BAYER_PHASE[bayer])
    assert (corners == 16 * colour[0, 0].astype(int).reshape(1, 1, 3, 1, 1)).all()


@both
def test_a_ramp_stays_a_ramp_away_from_the_edges(needs):
    """Each kernel is exact for a linear picture, whose three colours have the same slope."""
    v, u = np.indices((12, 14))
    colour = np.stack([3 * u + 2 * v + first for first in (10, 60, 90)], axis=-1).astype(np.uint8)
    windows = raw_windows(mosaic(colour, "GBRG"), GRADIENT)
    y0, x0 = np.mgrid[2:9, 2:11]
    corners = DECODERS[needs](windows[y0, x0], x0, y0, BAYER_PHASE["GBRG"])
    for j in range(2):
        for i in range(2):
            np.testing.assert_array_equal(np.moveaxis(corners[j, i], 0, -1),
                                          16 * colour[y0 + j, x0 + i].astype(int))


def test_the_direction_is_that_of_stripes_and_turns_with_them():
    rng = np.random.default_rng(7)
    windows = rng.integers(0, 256, (500, 6, 6))
    np.testing.assert_array_equal(twice_direction(windows.swapaxes(1, 2)),
                                  -twice_direction(windows))
    along_columns = np.broadcast_to(rng.integers(0, 256, (500, 1, 6)), (500, 6, 6))
    assert (twice_direction(along_columns) <= 0).all()
    assert (twice_direction(along_columns) == -2).mean() > .9
    assert not twice_direction(np.full((1, 6, 6), 90)).any()


def test_a_transposed_window_has_transposed_colours_but_for_rounding():
    windows = np.random.default_rng(9).integers(0, 256, (300, 6, 6))
    turned = directional_colours(windows.swapaxes(1, 2), 0, 0, (0, 0))
    upright = directional_colours(windows, 0, 0, (0, 0)).swapaxes(0, 1)
    assert 0 < np.abs(turned - upright).max() <= 2      # sixteenths: halves are rounded down


def test_samples_outside_the_frame_are_mirrored():
    raw = np.random.default_rng(2).integers(0, 256, (8, 9), np.uint8)
    windows = raw_windows(raw, GRADIENT)
    assert windows.shape == (7, 8, 6, 6)        # a first pixel in each row and column but the last
    np.testing.assert_array_equal(windows[0, 0, 0], raw[2, [2, 1, 0, 1, 2, 3]])
    np.testing.assert_array_equal(windows[6, 7, 5], raw[5, [5, 6, 7, 8, 7, 6]])


def test_positions_just_outside_are_moved_in_and_others_are_blank():
    geometry, q = Geometry(8, 8, 20, 16, interpolation=GRADIENT), Q(14, 10)

    def at(x):
        x0, _, fx, _, inside = window_address(q.quantise(x), q.quantise(5.0), geometry, q)
        return (int(x0), int(fx)) if inside else None
    assert at(-1.001) is None and at(-1.0) == (0, 0) and at(-.5) == (0, 0)
    assert at(0.5) == (0, 512) and at(18.25) == (18, 256)
    assert at(19.0) == (18, 1023) and at(19.999) == (18, 1023) and at(20.0) is None


def test_rounding_is_to_nearest_but_for_what_a_row_cuts_off():
    corners = np.random.default_rng(3).integers(0, 16 * 255 + 1, (2, 2, 3, 500))
    fx, fy = np.random.default_rng(4).integers(0, 1024, (2, 500))
    exact = sum(weight * corners[j, i] for j, i, weight in (
        (0, 0, (1024 - fx) * (1024 - fy)), (0, 1, fx * (1024 - fy)),
        (1, 0, (1024 - fx) * fy), (1, 1, fx * fy))) / 2**24
    error = bilinear(corners, fx, fy, 10, GRADIENT).T - exact
    assert error.max() <= .5 and -.5 - 1 / 64 <= error.min() < -.5


def test_grey_is_bilinear_between_the_samples_of_every_row_and_column():
    geometry = Geometry(8, 8, 10, 9, bayer=MONO, interpolation=GRADIENT)
    raw = np.random.default_rng(5).integers(0, 256, (9, 10), np.uint8)
    y0, x0 = np.indices((8, 9))
    corners = corner_colours(raw_windows(raw, GRADIENT)[y0, x0], x0, y0, geometry)
    for j in range(2):
        for i in range(2):
            assert (corners[j, i] == corners[j, i, :1]).all()
            np.testing.assert_array_equal(corners[j, i, 0], 16 * raw[y0 + j, x0 + i].astype(int))
    a, b, c, d = (raw[:-1, :-1], raw[:-1, 1:], raw[1:, :-1], raw[1:, 1:])
    middle = (a.astype(int) + b + c + d + 2) // 4
    np.testing.assert_array_equal(bilinear(corners, 512, 512, 10, GRADIENT)[..., 1], middle)


def test_a_grey_sensor_is_a_bit_of_the_register_of_the_phase(tmp_path):
    grey = gradient_descriptor(bayer=MONO)
    assert host_values(grey)["BAYER_PHASE"] == BAYER_MONO
    assert all(host_values(gradient_descriptor(bayer=each))["BAYER_PHASE"] < BAYER_MONO
               for each in BAYER_PHASE)
    grey.save(tmp_path / "grey.toml")
    loaded = Descriptor.load(tmp_path / "grey.toml")
    assert loaded.geometry.mono and loaded.digest == grey.digest
    with pytest.raises(InputError, match="bayer is MONO, a grey sensor needs the interpolation "
                                         "gradient or directional, not fast"):
        replace(grey.geometry, interpolation=FAST)


def test_a_descriptor_keeps_its_interpolation(tmp_path):
    fast, gradient = barrel_descriptor(), barrel_descriptor(interpolation=GRADIENT)
    assert gradient.digest != barrel_descriptor().digest
    fast.save(tmp_path / "fast.toml")
    gradient.save(tmp_path / "gradient.toml")
    assert "interpolation" not in (tmp_path / "fast.toml").read_text()
    assert Descriptor.load(tmp_path / "fast.toml").geometry.interpolation == FAST
    loaded = Descriptor.load(tmp_path / "gradient.toml")
    assert loaded.geometry.interpolation == GRADIENT and loaded.digest == gradient.digest
    text = (tmp_path / "gradient.toml").read_text().replace('"gradient"', '"cubic"')
    (tmp_path / "cubic.toml").write_text(text)
    with pytest.raises(InputError, match="the interpolation is 'cubic', one of fast, gradient, "):
        Descriptor.load(tmp_path / "cubic.toml")


def test_few_fraction_bits_of_coordinates_are_rejected():
    for needs, bits in ((GRADIENT, 3), (DIRECTIONAL, 3)):
        d = barrel_descriptor(interpolation=needs)
        coordinate = Q(d.formats.coordinate.i_bits, bits)
        with pytest.raises(InputError, match=f"{needs.name} needs 4"):
            replace(d, formats=replace(d.formats, coordinate=coordinate))


def test_hardware_states_which_it_has():
    for needs in (FAST, GRADIENT, DIRECTIONAL):
        made = Hardware().made_for(barrel_descriptor(interpolation=needs))
        word = capabilities(made, 48, 40)["CAPABILITIES"]
        assert [name for name, bit in INTERPOLATION_BITS.items() if word & bit] == [needs.name]
    paper = Hardware(fetcher="multiport").made_for(barrel_descriptor())
    assert capabilities(paper, 48, 40)["CAPABILITIES"] & INTERPOLATION_BITS[FAST.name]


def test_a_fetcher_without_such_windows_is_rejected():
    gradient = gradient_descriptor()
    with pytest.raises(InputError, match="interpolation is gradient, the multiport fetcher"):
        Hardware(fetcher="multiport").made_for(gradient)
    fast_cache = Hardware().made_for(barrel_descriptor((48, 40), (64, 48))).cache
    with pytest.raises(InputError, match="cache is for the interpolation fast"):
        replace(Hardware(), cache=fast_cache).made_for(gradient)
