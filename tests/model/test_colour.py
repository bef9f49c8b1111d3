"""White balance and tone in the golden model: exact curves, sums, gains, what is rejected."""

import numpy as np
import pytest

from ncdc_model.golden.colour import ColourSums, coloured, gains_of
from ncdc_model.golden.corrector import Corrected
from ncdc_model.golden.tone import GAMMA_LIMITS, exact_tone, tone_named, toned
from ncdc_spec.colour import Colour
from ncdc_spec.errors import InputError
from ncdc_spec.tone import LINEAR
from ncdc_spec.white_balance import LARGEST_GAIN, UNITY, grey_world

VALUES = np.arange(256)


def frame(seed=1, blank=.3):
    """A corrected frame of random pixels, of which some have no source."""
    rng = np.random.default_rng(seed)
    return Corrected(rng.integers(0, 256, (40, 30, 3), np.uint8), rng.random((40, 30)) < blank, 0)


@pytest.mark.parametrize("name", ["linear", "sRGB", *(
    f"gamma:{gamma:.2f}" for gamma in np.arange(GAMMA_LIMITS[0], GAMMA_LIMITS[1] + .05, .1))])
def test_a_named_tone_is_within_one_grey_level_of_the_exact_table(name):
    difference = toned(VALUES, tone_named(name)) - np.floor(exact_tone(name) + .5)
    assert np.abs(difference).max() <= (name != "linear" and name != "gamma:1.00")


def test_equal_pieces_would_miss_by_many_grey_levels():
    """Why the pieces are short near black: 16 equal ones between the same exact values."""
    positions = np.arange(0, 257, 16)
    equal = np.interp(VALUES, positions, exact_tone("gamma:2.2", positions))
    assert np.abs(equal - exact_tone("gamma:2.2")).max() > 20


def test_srgb_is_that_of_the_standard():
    """Code values of a few linear intensities, as IEC 61966-2-1 has them."""
    known = {0: 0, 1: 13, 55: 128, 128: 188, 255: 255}
    assert {v: round(float(exact_tone("sRGB", v))) for v in known} == known


def test_the_curve_goes_through_its_nodes_and_straight_between():
    nodes = tuple(256 - node for node in LINEAR)
    assert toned(VALUES, nodes).tolist() == [min(255, 256 - v) for v in range(256)]


def test_neutral_colour_changes_nothing():
    np.testing.assert_array_equal(coloured(frame(), Colour()), frame().picture)


def test_a_gain_rounds_and_clamps_and_blank_pixels_keep_the_fill():
    colour = Colour((LARGEST_GAIN, UNITY // 2, 0))
    out, before = coloured(frame(), colour), frame()
    exact = before.picture * (np.array(colour.gains) / UNITY)
    expected = np.minimum(255, np.floor(exact + .5))
    expected[before.blank] = before.picture[before.blank]
    np.testing.assert_array_equal(out, expected)


def test_sums_are_of_pixels_with_a_source():
    f = frame()
    sums = ColourSums.of(f)
    weights = ~f.blank[..., None]
    assert sums.colours == tuple((f.picture.astype(int) * weights).sum(axis=(0, 1)).tolist())
    assert sums.pixels == (~f.blank).sum()


def test_sums_of_the_largest_frame_fit_32_bits():
    assert 4096 * 4096 * 255 < 1 << 32


def test_grey_world_makes_the_means_equal():
    rng = np.random.default_rng(2)
    picture = (rng.random((60, 60, 1)) * [90, 200, 120]).astype(np.uint8)
    f = Corrected(picture, np.zeros((60, 60), bool), 0)
    gains = grey_world(ColourSums.of(f).colours)
    assert gains[1] == UNITY and min(gains) == UNITY
    means = coloured(f, Colour(gains)).mean(axis=(0, 1))
    assert np.ptp(means) < .5 < np.ptp(picture.mean(axis=(0, 1)))


@pytest.mark.parametrize("sums,gains", [
    ((0, 0, 0), (256, 256, 256)), ((7, 7, 7), (256, 256, 256)), ((0, 9, 9), (1023, 256, 256)),
    ((1, 2, 3), (768, 384, 256)), ((1, 2**32 - 1, 5), (1023, 256, 1023)),
    ((512, 513, 1), (257, 256, 1023))])
def test_grey_world_of_odd_sums(sums, gains):
    assert grey_world(sums) == gains


@pytest.mark.parametrize("sums,present,gains", [
    ((100, 100, 100), (512, 256, 300), (512, 256, 300)),    # balanced: the same again
    ((100, 100, 100), (1000, 512, 600), (500, 256, 300)),   # but the least gain is 1.0
    ((100, 200, 160), (256, 512, 256), (410, 410, 256)),
    ((0, 7, 7), (0, 256, 256), (1023, 256, 256)), ((0, 0, 0), (1, 2, 3), (256, 256, 256)),
    ((7, 7, 7), (0, 1, 256), (256, 256, 1023)),             # a gain of 0 counts as 1
    ((2**32 - 1, 2**32 - 1, 1), (1023, 1, 1), (1023, 256, 1023))])
def test_grey_world_of_sums_with_gains(sums, present, gains):
    assert grey_world(sums, present) == gains


def test_an_estimate_from_balanced_samples_comes_to_rest():
    """Whatever the colours of the light: the second estimate is the first one, but for rounding."""
    rng = np.random.default_rng(9)
    for light in rng.uniform(.3, 1, (200, 3)):
        gains, history = tuple(rng.integers(64, 1024, 3).tolist()), []
        for _ in range(3):
            sums = [int(1e6 * part * gain / 256) for part, gain in zip(light, gains)]
            gains = grey_world(sums, gains)
            history.append(gains)
        assert min(gains) == 256 and history[1] == history[2]
        assert np.abs(np.subtract(history[0], history[1])).max() <= 1


def test_gains_are_rounded_to_256ths():
    assert gains_of("1.8, 1,1.4") == (461, 256, 358)
    assert gains_of("0.00390625,3.99609375,1e0") == (1, 1023, 256)


@pytest.mark.parametrize("text,sentence", [
    ("0,1,1", "the gain of red is 0, the limits are 0.00390625 and 3.99609375"),
    ("1,-2,1", "the gain of green is -2, the limits"), ("1,1,nan", "the gain of blue is nan, the"),
    ("1,1,5.0", "the gain of blue is 5.0, the limits"), ("inf,1,1", "the gain of red is inf, the"),
    ("1,a,1", "the gain of green is 'a', a number is needed"),
    ("1,1,1,1,1", "the white balance is '1,1,1,1,1', three gains R,G,B or grey-world is needed"),
    ("gray", "the white balance is 'gray', three gains"), ("", "the white balance is '', three")])
def test_white_balance_that_is_none(text, sentence):
    with pytest.raises(InputError, match=sentence.replace(".", r"\.")):
        gains_of(text)


@pytest.mark.parametrize("name,sentence", [
    ("rec709", "the tone is 'rec709', one of linear, sRGB, gamma:G is needed"),
    ("", "the tone is '', one of"), ("gamma:0.5", "gamma of the tone is 0.5, the limits are 1 and"),
    ("gamma:nan", "the gamma of the tone is nan, the"), ("gamma:", "is '', a number is needed"),
    ("gamma:two", "the gamma of the tone is 'two', a number is needed"),
    ("gamma:-1", "the gamma of the tone is -1, the limits are 1 and 3")])
def test_tone_that_is_none(name, sentence):
    with pytest.raises(InputError, match=sentence):
        tone_named(name)


@pytest.mark.parametrize("arguments,sentence", [
    (((256, 256),), "there are 2 gains, 3 are needed"),
    (((256, 1024, 256),), "the gain of green is 1024 256ths, it must be an integer of 0 to 1023"),
    (((256, 1.5, 256),), "the gain of green is 1.5 256ths"),
    (((256,) * 3, (0,) * 16), "the tone curve has 16 nodes, it must have 17"),
    (((256,) * 3, (0,) * 16 + (257,)), "a node of the tone curve is 257, it must be an integer")])
def test_settings_that_are_none(arguments, sentence):
    with pytest.raises(InputError, match=sentence):
        Colour(*arguments)
