"""The benches that a mutant must pass to survive, on the designs as they are; see
``test_mutation_benches.py`` for the corrector's."""

from functools import cache

import pytest

from mutation.bridges import DESIGN as BRIDGES
from mutation.csi2 import DESIGN as CSI2
from mutation.packetiser import DESIGN as PACKETISER
from mutation.screen import DESIGN as SCREEN
from mutation.sdram import DESIGN as SDRAM
from mutation.system import DESIGN as SYSTEM
from ncdc_bench.mutation.designs import designs
from ncdc_bench.mutation.netlist import distinct_modules
from ncdc_hdl.export.verilog import module_verilog

DESIGNS = BRIDGES, CSI2, PACKETISER, SCREEN, SDRAM, SYSTEM


@cache
def verilog_of(design):
    """The Verilog of a design, made once."""
    return module_verilog(design.make(), design.top)


@pytest.mark.longer
@pytest.mark.parametrize("design,bench", [
    pytest.param(design, bench, id=f"{design.name}, {bench.name}")
    for design in DESIGNS for bench in design.benches])
def test_bench(design, bench):
    bench.run(verilog_of(design), ())


def test_every_design_is_tested():
    elsewhere = {designs()[name] for name in ("cache", "core", "front", "nodes", "units")}
    assert {*DESIGNS} == {*designs().values()} - elsewhere      # test_mutation_benches


def test_a_design_leaves_the_modules_of_an_instance_to_another():
    assert SDRAM.judged() is None
    every = [one.name for one in distinct_modules(SYSTEM.make(), SYSTEM.top)]
    judged = SYSTEM.judged()
    left = {name for name in every if name not in judged}
    assert {"ncdc_system", "ncdc_system_capture", "ncdc_system_burst_writer"} <= {*judged}
    assert {"ncdc_system_corrector", "ncdc_system_cache", "ncdc_system_relay_entry"} <= left
    assert "ncdc_system_relay_entries" in judged
