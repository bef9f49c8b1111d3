"""Tan-sigmoid: choice of the parameters, rejected ones, planted errors that must be found."""

import re

import numpy as np
import pytest
from amaranth import Const
from amaranth.back import rtlil

from ncdc_hdl.neural import classic, lvc, mmhbc
from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.errors import InputError
from ncdc_spec.tansig import (
    FRACTION_BITS,
    ClassicDesign,
    TableDesign,
    TansigDesign,
    design_for,
    tansig,
)
from ncdc_spec.tansig.lvc import quotient, quotient_error
from ncdc_spec.tansig.mmhbc_bound import error_terms
from tansig_tuning import monotonic_tuning
from tansigs import NAMES, errors, every_design, every_magnitude, gateware, stimuli


@pytest.fixture
def design(request):
    return design_for(*request.param)


@pytest.mark.parametrize("bits", FRACTION_BITS)
def test_a_narrower_mmhbc_is_rejected_and_so_is_a_smaller_table(bits):
    design = TansigDesign.for_bits(bits)
    for width, regions in [(design.width - 1, range(3, design.region_bits + 1)),
                           (design.width, range(3, design.region_bits))]:
        for region_bits in regions:
            with pytest.raises(InputError, match="not faithful"):
                TansigDesign(design.input, bits, width, region_bits)


@pytest.mark.parametrize("make,message", [
    (lambda: TansigDesign(width=24), r"mmhbc tan-sigmoid input Q5.19, fraction_bits 20, width 24, "
     r"region_bits 5 is not faithful: its error bound is 1\.52\d units of 2\*\*-20, below 1"),
    (lambda: TansigDesign(width=19), "shifts by 20, width 19 is the limit"),
    (lambda: TansigDesign(region_bits=19), "region_bits is 19, the limits are 1 and 18"),
    (lambda: ClassicDesign(width=18), "width is 18, the last shift 22 and the input's 19"),
    (lambda: ClassicDesign(width=23), r"classic .* error bound is \d\.\d+ units of 2\*\*-20"),
    (lambda: TableDesign(segment_bits=(3, 2, 1)), r"table .* error bound is \d\.\d+ units"),
    (lambda: TableDesign(segment_bits=(3, 3, 1)), r"segment_bits are \(3, 3, 1\), they must fall"),
    (lambda: TableDesign(offset_bits=20), "offset_bits is 20, the limits are 21 and 49"),
    (lambda: TansigDesign.for_bits(17), "has 17 fraction bits, one of 16, 18, 20, 22 is needed"),
    (lambda: design_for("taylor"), "variant is 'taylor', one of mmhbc, classic, table is needed"),
])
def test_rejects(make, message):
    with pytest.raises(InputError, match=message):
        make()


def test_costs():
    assert [(d.variant, d.fraction_bits, d.multipliers, d.adders, d.stages, d.table_bits)
            for d in (design_for(*name) for name in NAMES if name[1] in (16, 20))] == [
        ("mmhbc", 16, 0, 33, 33, 5376), ("mmhbc", 20, 0, 36, 36, 12800),
        ("classic", 16, 1, 80, 41, 368), ("classic", 20, 1, 93, 48, 416),
        ("table", 16, 2, 3, 5, 3968), ("table", 20, 2, 3, 5, 8176)]


# Multiplications for blocks of 18 bits. Of the table's four parts one, of two bits, is an adder.
MULTIPLICATIONS = {"mmhbc": 0, "classic": 4, "table": 3}


@every_design()
def test_costs_are_those_of_the_netlist(design):
    """Adders of mmhbc exactly; the others have a few more for the parts of products, and narrow
    ones next to the data path, at most 6."""
    netlist = rtlil.convert(Tansig(design), name="tansig")
    adders = len(re.findall(r"cell \$(?:add|sub|neg) ", netlist))
    assert len(re.findall(r"cell \$mul ", netlist)) == MULTIPLICATIONS[design.variant]
    assert 0 <= adders - design.adders <= (0 if design.variant == "mmhbc" else 6)


def test_every_term_of_the_budget_counts():
    terms = error_terms(TansigDesign(), known=0)
    largest = {name: float(term.max()) for name, term in terms.items() if name != "a"}
    assert largest["digit"] == .5
    assert min(largest[name] for name in ("known", "rotations", "angle", "quotient")) > .01
    # What is known of the first rotations only ever tightens the bound.
    assert TansigDesign().bound_ulp < largest["total"]


def test_the_quotients_bound_holds_on_single_points():
    width, digits = 25, 21
    u = np.random.default_rng(2).integers(0, (1 << width) + 1, 200_000)
    one = 1 << width
    exact = (one - u) / (one + u)
    error = np.abs(quotient(u, width, digits) / 2.0**digits - exact) - 2.0**-digits
    # Of a point all roundings are known, of an interval only those of the high shifts.
    point, interval = (quotient_error(lo * 1., hi * 1., width, digits) / one
                       for lo, hi in ((u, u), (u & -4096, u | 4095)))
    assert (error <= point + 1e-15).all() and (point <= interval + 1e-15).all()
    assert error.max() > .5 * point.max()


@pytest.mark.regress
@every_design([name for name in NAMES if name[0] != "classic"])
def test_the_tuned_entries_are_those_of_the_rule(design):
    tuned, plain = ((design.table, design.rounded_table) if design.variant == "mmhbc" else
                    ([row[0] for row in rows] for rows in (design.coefficients, design.fitted)))
    changed = {k: a - b for k, (a, b) in enumerate(zip(tuned, plain)) if a != b}
    reach = 2 if design.variant == "mmhbc" else 12
    assert changed and monotonic_tuning(design, reach) == changed


class WithoutTuning(TansigDesign):
    """Without the entries that make it monotonic."""
    table = property(lambda self: self.rounded_table)


class WrongEntry(TansigDesign):
    """One table entry a unit too large."""

    @property
    def table(self):
        return tuple(entry + (k == 300) for k, entry in enumerate(TansigDesign().table))


class TruncatedRotation(TansigDesign):
    """The last rotation does not round."""

    def _rotate(self, u, a):
        for k, shift in enumerate(self.shifts):
            half = 0 if k == len(self.shifts) - 1 else 1 << (shift - 1)
            step = (u + half) >> shift
            u = u + np.where((a >> (self.fine_bits - 1 - k)) & 1, -step, step)
        return u


@pytest.mark.parametrize("wrong", [
    WithoutTuning(), pytest.param(WrongEntry(), marks=pytest.mark.longer), TruncatedRotation()],
                         ids=lambda d: type(d).__name__)
def test_every_input_shows_a_planted_error(wrong):
    n = np.concatenate([np.arange(32 << 14), np.arange(196 << 14, 197 << 14),
                        np.arange(300 << 14, 301 << 14)])
    assert (tansig(n, wrong) != tansig(n, TansigDesign())).any()


def test_without_tuning_a_result_decreases():
    n = np.arange(3215300, 3215400)
    assert (np.diff(tansig(n, WithoutTuning())) < 0).sum() == 1
    assert (np.diff(tansig(n, TansigDesign())) >= 0).all()


@pytest.mark.longer
def test_a_narrow_table_breaks_the_bound():
    class Narrow(TansigDesign):
        def _bound(self):
            return 0.

    design = Narrow(width=23)
    assert np.abs(errors(every_magnitude(design), design)).max() > 1


PLANTED = {                # module, its call of add_signed that is wrong, how
    "last rotation's carry": (mmhbc, 13, lambda a, b, subtract, carry: (a, b, subtract, 0)),
    "last remainder's carry": (lvc, 19, lambda a, b, subtract, carry: (a, b, subtract, 0)),
    "second digit's sign": (lvc, 1, lambda a, b, subtract, carry: (a, b, ~subtract, carry)),
    "repeated iteration's carry": (classic, 9, lambda a, b, subtract, carry: (a, b, subtract, 0)),
}


@pytest.mark.parametrize("name", PLANTED)
def test_gateware_shows_a_planted_error(name, monkeypatch):
    module, number, change = PLANTED[name]
    right, calls = module.add_signed, []

    def wrong(a, b, subtract, carry):
        calls.append(None)
        if len(calls) - 1 != number:
            return right(a, b, subtract, carry)
        a, b, subtract, carry = change(a, b, subtract, carry)
        return right(a, b, subtract, Const(0, 1) if isinstance(carry, int) else carry)

    monkeypatch.setattr(module, "add_signed", wrong)
    design = design_for("classic" if module is classic else "mmhbc")
    n = stimuli(design, 500)
    assert (gateware(design, n) != tansig(n, design)).any()
    assert len(calls) > number
