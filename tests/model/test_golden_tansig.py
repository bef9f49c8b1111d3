"""The tan-sigmoid's integers compared with plain loops, and its tables with exact values."""

import re
from dataclasses import dataclass
from typing import ClassVar

import mpmath
import numpy as np
import pytest

from ncdc_spec.errors import InputError
from ncdc_spec.fixed import Q
from ncdc_spec.tansig import design_for
from ncdc_spec.tansig.design import Design, tansig

mpmath.mp.dps = 50


@dataclass(frozen=True)
class Line(Design):
    """f(a) = 2 a + 1: a design without a table."""
    slope: int = 2
    bound: float = .5
    variant: ClassVar[str] = "line"
    _DEFAULTS: ClassVar[dict] = {8: {"slope": 2}, 9: {"slope": 4}}

    def magnitude(self, a):
        assert a.dtype == np.int64 and a.ndim == 1 and a.size <= 1 << 15 and (a >= 0).all()
        return self.slope * a + 1

    def _check(self):
        if self.slope < 0:
            raise InputError("it falls")

    def _bound(self):
        return self.bound


def test_signs_zero_and_the_most_negative_input():
    design = Line(Q(5, 4), 8)
    n = np.array([[0, 1, -1, 7], [255, -255, -256, -8]])
    np.testing.assert_array_equal(tansig(n, design), [[0, 3, -3, 15], [511, -511, -511, -17]])
    assert design.largest == 511 and type(design.largest) is int
    assert tansig(-256, design).shape == () and tansig([], design).shape == (0,)


@pytest.mark.parametrize("size", [32767, 32768, 32769, 65536, 70001])
def test_inputs_beyond_a_chunk(size):
    n = np.arange(size) % 511 - 255
    np.testing.assert_array_equal(tansig(n, Line(Q(5, 4), 8)), 2 * n + np.sign(n))


def test_parameters_of_a_design():
    assert Line() == Line(Q(5, 19), 20)
    design = Line.for_bits(9)
    assert design == Line(Q(5, 19), 9, 4) and design.output == Q(1, 10)
    assert Line.for_bits(8, Q(4, 4)) == Line(Q(4, 4), 8, 2)
    assert design.bound_ulp == .5                       # which is kept, and no parameter
    assert design.parameters == "input Q5.19, fraction_bits 9, slope 4, bound 0.5"
    with pytest.raises(AttributeError):
        design.slope = 3
    with pytest.raises(TypeError):
        Design()
    with pytest.raises(InputError, match="the line tan-sigmoid has 7 fraction bits, one of 8, 9 "):
        Line.for_bits(7)
    with pytest.raises(InputError, match="it falls"):
        Line(slope=-1)
    assert Line(bound=.999).bound == .999
    for bound in (1, 1.25):
        with pytest.raises(InputError, match=re.escape(
                f"the line tan-sigmoid input Q5.19, fraction_bits 20, slope 2, bound {bound} is "
                f"not faithful: its error bound is {bound:.3f} units of 2**-20, below 1 is")):
            Line(bound=bound)


def test_a_design_computes_its_bound_and_largest_once():
    calls = []

    class Counted(Line):
        def magnitude(self, a):
            calls.append("magnitude")
            return super().magnitude(a)

        def _bound(self):
            calls.append("bound")
            return .5
    design = Counted()
    assert [(design.bound_ulp, design.largest) for _ in range(3)] == 3 * [(.5, 2**24 - 1)]
    assert calls == ["bound", "magnitude"]


@pytest.mark.parametrize("missing", ["magnitude", "_check", "_bound"])
def test_a_design_without_a_method_is_none(missing):
    given = {name: lambda self: 0 for name in ("magnitude", "_check", "_bound") if name != missing}
    with pytest.raises(TypeError, match=missing):
        type("Part", (Design,), given)()


def test_designs_are_chosen_by_name():
    design = design_for("table", 18)
    assert (design.variant, design.fraction_bits, design.input) == ("table", 18, Q(5, 19))
    assert design_for("table", 18) is design
