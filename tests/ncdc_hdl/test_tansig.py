"""Tan-sigmoid: golden model compared with exact values, gateware with the golden model."""

import mpmath
import numpy as np
import pytest

from ncdc_hdl.neural.lookup import Lookup
from ncdc_spec.fixed import Q
from ncdc_spec.tansig import TableDesign, TansigDesign, design_for, tansig
from pipelines import run_pipeline
from tansigs import edges, errors, every_design, every_magnitude, gateware, stimuli


@pytest.fixture
def design(request):
    return design_for(*request.param)


def check_every_magnitude(design):
    q = every_magnitude(design)
    error = np.abs(errors(q, design))
    assert error.max() < design.bound_ulp < 1.3 * error.max()
    assert (np.diff(q) >= 0).all()
    assert q[0] == 0 and (q[1:] & 1).all() and q[-1] == design.output.hi
    ideal = 1.3 if design.fraction_bits == 16 else 1.1
    assert (error**2).mean() < ideal / 12
    return error


@pytest.mark.longer
def test_every_magnitude():
    design = TansigDesign()
    error = check_every_magnitude(design)
    assert error.max() <= 0.79
    assert (error <= 0.5).mean() >= 0.95
    assert (design.multipliers, design.adders, design.table_bits) == (0, 36, 12800)


@pytest.mark.regress
@every_design()
def test_every_magnitude_of_every_design(design):
    check_every_magnitude(design)


@every_design()
def test_the_bound_holds_where_doubles_might_not_decide(design):
    rng = np.random.default_rng(3)
    for n in np.concatenate([edges(design)[::37], rng.integers(0, design.input.hi, 50)]).tolist():
        exact = mpmath.tanh(mpmath.mpf(n) / 2**(design.input.f_bits + 1))
        result = mpmath.mpf(int(tansig(n, design))) / 2**design.output.f_bits
        assert abs(result - exact) * 2**design.fraction_bits < design.bound_ulp < 1, n


@every_design()
def test_odd_zero_and_saturated(design):
    n = edges(design)
    n = n[n > design.input.lo]
    np.testing.assert_array_equal(tansig(-n, design), -tansig(n, design))
    assert tansig(0, design) == 0
    lowest = tansig(design.input.lo, design)
    assert lowest == -tansig(design.input.hi, design) == design.output.lo + 1


@every_design()
def test_gateware_equals_model(design):
    n = stimuli(design, 500)
    np.testing.assert_array_equal(gateware(design, n), tansig(n, design))


@pytest.mark.parametrize("input", [Q(5, 17), Q(4, 18)], ids=str)
def test_gateware_of_another_input_equals_the_model(input):
    """The most negative n of the shorter range is no largest result."""
    design = TansigDesign(input, 18, 23)
    assert (design.largest == design.output.hi) == (input.i_bits == 5)
    n = stimuli(design, 300)
    assert input.lo in n
    np.testing.assert_array_equal(gateware(design, n), tansig(n, design))


@pytest.mark.parametrize("design", [
    TableDesign(Q(5, 20), 20, (4, 3, 1), 31, 26), TableDesign(Q(5, 17), 16, (3, 2, 1), 23, 22)],
    ids=lambda design: str(design.input))
def test_gateware_of_tables_of_another_input_equals_the_model(design):
    """Positions of 19 and of 16 bits: above and below the cut of the products."""
    n = stimuli(design, 300)
    np.testing.assert_array_equal(gateware(design, n), tansig(n, design))


@pytest.mark.parametrize("entries", [5, 64, 112, 256, 512, 2048])
def test_a_table_in_logic(entries):
    rng = np.random.default_rng(entries)
    values = rng.integers(0, 1 << 9, entries).tolist()
    dut, i = Lookup(values, 9), rng.permutation(entries).tolist()
    got = run_pipeline(dut, i, lambda ctx, x: ctx.set(dut.i, x), lambda: [dut.o])
    assert np.ravel(got).tolist() == [values[k] for k in i]
