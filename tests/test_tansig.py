"""Tan-sigmoid: golden model against exact values, gateware against the golden model."""

import mpmath
import numpy as np
import pytest
from pipelines import run_pipeline

from ncdc_hdl.neural.tansig import Tansig
from ncdc_model.fixed import Q
from ncdc_model.tansig import TansigDesign, tansig

DESIGNS = [TansigDesign(), TansigDesign(fraction_bits=16, width=20),
           TansigDesign(Q(5, 17), fraction_bits=18, width=23)]


def edges(design):
    """Inputs around every region boundary, around zero and at both ends."""
    q = design.input
    regions = np.arange(0, q.hi, 1 << design.fine_bits)
    near = (regions[:, None] + np.arange(-2, 3)).ravel()
    return np.unique(np.clip(np.concatenate([near, -near, [q.lo, q.lo + 1, q.hi]]), q.lo, q.hi))


def test_every_magnitude_is_faithful():
    design = TansigDesign()
    n = np.arange(design.input.hi + 1)
    error = np.abs(design.output.real(tansig(n)) - np.tanh(design.input.real(n) / 2)) * 2.0**20
    # tanh in double precision is wrong by 2**-33 of an ulp here: it cannot decide the comparison.
    assert error.max() < 0.79
    assert (error <= 0.5).mean() > 0.95


def test_faithful_where_doubles_might_not_decide():
    design = TansigDesign()
    for n in edges(design)[::37].tolist():
        exact = mpmath.tanh(mpmath.mpf(n) / 2**20)
        assert abs(mpmath.mpf(int(tansig(n))) / 2**21 - exact) * 2**20 < 0.79, n


@pytest.mark.parametrize("design", DESIGNS, ids=str)
def test_odd_zero_and_saturated(design):
    n = edges(design)
    n = n[n > design.input.lo]
    np.testing.assert_array_equal(tansig(-n, design), -tansig(n, design))
    assert tansig(0, design) == 0
    assert tansig(design.input.lo, design) == -tansig(design.input.hi, design) == design.output.lo + 1


@pytest.mark.parametrize("design", DESIGNS, ids=str)
def test_gateware_equals_model(design):
    rng = np.random.default_rng(7)
    n = np.concatenate([rng.choice(edges(design), 800), edges(design)[:3], edges(design)[-3:],
                        [0, 1, -1], rng.integers(design.input.lo, design.input.hi, 800)])
    dut = Tansig(design)
    got = run_pipeline(dut, n.tolist(), lambda ctx, x: ctx.set(dut.i, x), lambda: [dut.o])
    np.testing.assert_array_equal(np.ravel(got), tansig(n, design))


def test_refuses_a_width_below_its_shifts():
    with pytest.raises(ValueError, match="shifts by 20, width 19 is the limit"):
        TansigDesign(width=19)
