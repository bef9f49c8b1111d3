"""The benches that a mutant must pass to survive, on the designs as they are.

The same benches run on each mutant in ``ncdc bench mutation``; so what they find there, these tests
find in a changed gateware.
"""

from functools import cache

import pytest

from mutation.core import DESIGN as CORE
from ncdc_hdl.export.verilog import module_verilog


@cache
def verilog_of(design):
    """The Verilog of a design, made once."""
    return module_verilog(design.make(), design.top)


@pytest.mark.longer
@pytest.mark.parametrize("bench", CORE.benches, ids=lambda bench: bench.name)
def test_bench_of_core(bench):
    bench.run(verilog_of(CORE), ())
