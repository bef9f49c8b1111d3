"""How deep samples are, and their upper eight bits."""

import numpy as np
import pytest

from ncdc_model.samples import check_bits, eight_bits, scaled
from ncdc_spec.errors import InputError


@pytest.mark.parametrize("bits", range(8, 17))
def test_all_ones_are_white_and_upper_bits_are_used(bits):
    values = np.arange(1 << bits, dtype=np.uint16)
    assert (scaled(values, (1 << bits) - 1) == values >> (bits - 8)).all()


@pytest.mark.parametrize("white", [1, 3, 15, 100, 127, 254, 256, 1000, 4000])
def test_other_whites_are_scaled_and_rounded(white):
    values = np.arange(white + 1)
    wanted = np.floor(values * 255 / white + .5)
    assert (scaled(values.astype(np.uint16), white) == wanted).all()
    assert scaled(np.array([65535], np.uint16), white) == 255


def test_what_is_declared_decides():
    values, said = np.array([[0, 511]], np.uint16), []
    assert eight_bits(values, 1023, None, "a", said.append).tolist() == [[0, 127]]
    assert eight_bits(values, 1023, 10, "a", said.append).tolist() == [[0, 127]] and not said
    with pytest.raises(InputError, match=r"a declares samples of 10 bits \(0 to 1023\), --bits "
                                         "says 12"):
        eight_bits(values, 1023, 12, "a", said.append)
    with pytest.raises(InputError, match="a holds a sample of 511 and declares 500 as the largest"):
        eight_bits(values, 500, None, "a", said.append)
    with pytest.raises(InputError, match="declares samples of 8 bits .* --bits says 12"):
        eight_bits(values.astype(np.uint8), 255, 12, "a", said.append)
    assert eight_bits(values, None, None, "a", said.append).tolist() == [[0, 127]]
    assert said == ["a has 16-bit samples, the brightest is 511: taken as 10-bit; --bits says "
                    "otherwise"]


@pytest.mark.parametrize("bits", [7, 17, 0, -1])
def test_bits_have_limits(bits):
    with pytest.raises(InputError, match=f"samples of {bits} bits are asked for, the limits"):
        check_bits(bits)
