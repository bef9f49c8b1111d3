"""The test card: what the lens bends, its correction makes straight."""

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc_model.example.card import CODES, card_at, card_codes
from ncdc_model.golden.corrector import correct
from ncdc_spec.geometry import MONO
from ncdc_spec.interpolation import FAST, GRADIENT

SIZE = (384, 288)


def error(descriptor, raw_of):
    """Mean difference of a corrected card from the card itself, where it has a source, in levels
    of the brightest sample; the raw card is as the lens of ``raw_of`` sees it."""
    raw = (card_codes(raw_of) * (255 // (CODES - 1))).astype(np.uint8)
    result = correct(descriptor, raw)
    v, u = np.indices(SIZE[::-1])
    wanted = 255 * card_at(u, v, SIZE)
    return abs(result.picture - wanted)[~result.blank].mean() / 255


def test_correction_makes_the_card_straight():
    """The lens that bent it gives the card; another one gives something else."""
    lens, other = (barrel_descriptor(SIZE, SIZE, strength=strength) for strength in (.3, .1))
    assert error(lens, lens) < .06
    assert error(lens, other) > .15


@pytest.mark.parametrize("bayer,interpolation", [("GBRG", FAST), (MONO, GRADIENT)])
def test_all_codes_are_used(bayer, interpolation):
    codes = card_codes(barrel_descriptor(SIZE, SIZE, bayer=bayer, interpolation=interpolation))
    assert codes.dtype == np.uint8 and codes.shape == SIZE[::-1]
    assert set(np.unique(codes)) <= set(range(CODES)) and codes.max() == CODES - 1


def test_a_tall_card_has_square_meshes():
    """Lines are as far apart down as across, and one runs through the middle."""
    width, height = 240, 480
    v, u = np.indices((height, width))
    white = card_at(u, v, (width, height)).min(axis=-1) > .9
    for lines, middle in ((white.all(axis=0), (width - 1) / 2), (white.all(axis=1),
                                                                 (height - 1) / 2)):
        at = np.flatnonzero(lines)
        assert abs(at - middle).min() < 1
        assert set(np.diff(at)) == {1, 39}          # two pixels of each line are all white
