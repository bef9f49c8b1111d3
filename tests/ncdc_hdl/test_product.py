"""Products: every split of the factors gives the exact product, one per clock."""

import re

import pytest
from amaranth.back import rtlil

from ncdc_hdl.neural.product import Product
from units.products import check_product


@pytest.mark.parametrize("a_width,b_width,block", [
    (24, 24, 27), (24, 24, 18), (22, 24, 18), (18, 18, 18), (18, 24, 18), (24, 18, 18),
    (19, 19, 18), (35, 35, 18)])
def test_product(a_width, b_width, block):
    check_product(Product(a_width, b_width, block))


def multiplications(dut):
    """(bits as a signed number of a, of b) of every multiplication in the netlist."""
    text = rtlil.convert(dut, name="top", emit_src=False)
    cells = re.findall(r"cell \$mul .*?\n  end", text, re.DOTALL)
    return [tuple(int(re.search(rf"{x}_WIDTH (\d+)", cell)[1]) + (f"{x}_SIGNED 0" in cell)
                  for x in "AB") for cell in cells]


def test_every_part_fits_its_block():
    for widths in ((24, 24), (22, 24), (35, 35)):
        parts = multiplications(Product(*widths, 18))
        assert len(parts) == 4 and max(map(max, parts)) == 18
    assert len(multiplications(Product(18, 24, 18))) == 2
    assert multiplications(Product(18, 18, 18)) == [(18, 18)]
    assert multiplications(Product(24, 24, 27)) == [(24, 24)]


@pytest.mark.parametrize("block,latency", [(27, 3), (18, 6)])
def test_latency(block, latency):
    assert Product(24, 24, block).latency == latency


@pytest.mark.parametrize("wrong", [
    lambda factor, block: [factor[:17].as_signed(), factor[17:].as_signed()],
    lambda factor, block: [factor[:17], factor[17:]],
    lambda factor, block: [factor[:16], factor[16:].as_signed()]])
def test_finds_wrong_parts(wrong, monkeypatch):
    monkeypatch.setattr("ncdc_hdl.neural.product._parts", wrong)
    with pytest.raises(AssertionError):
        check_product(Product(24, 24, 18))


def test_rejects_factors_of_more_than_two_parts():
    with pytest.raises(ValueError, match="a factor has 36 bits, the limit for two parts is 35"):
        Product(24, 36, 18)
