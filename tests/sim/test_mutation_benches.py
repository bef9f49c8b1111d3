"""The benches that a mutant must pass to survive, on the designs as they are.

The same benches run on each mutant in ``ncdc bench mutation``; so what they find there, these tests
find in a changed gateware.
"""

import json
from functools import cache

import pytest

from ncdc_bench.mutation.designs import PlayedBench, designs
from ncdc_bench.mutation.record import RECORD, RENEW, reports_of
from ncdc_hdl.export.verilog import module_verilog


@cache
def verilog_of(design):
    """The Verilog of a design, made once."""
    return module_verilog(design.make(), design.top)


@pytest.mark.longer
@pytest.mark.parametrize("design,bench", [
    pytest.param(design, bench, id=f"{design.name}, {bench.name}")
    for design in designs().values() for bench in design.benches])
def test_played_bench(design, bench):
    """Right results, and exactly those of the record: pixels, clocks, counters."""
    recorded = json.loads(RECORD.read_text())[design.name].get(bench.name, [])
    found = reports_of(bench, verilog_of(design))
    assert found == recorded, (
        f"clocks or counters of the bench {bench.name!r} differ from the record; if the gateware "
        f"was to change them, run {RENEW}, and look at git diff")


def test_every_bench_is_recorded():
    recorded = json.loads(RECORD.read_text())
    assert {name: {*benches} for name, benches in recorded.items()} == {
        name: {bench.name for bench in design.benches if isinstance(bench, PlayedBench)}
        for name, design in designs().items()}
