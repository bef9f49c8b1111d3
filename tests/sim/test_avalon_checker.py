"""The protocol checkers in Verilog: every rule fires on a planted violation, under its own name."""

import pytest

from cases import cases
from ncdc_sim.benches import avalon_checker, axi_checker, stream_checker
from ncdc_sim.cocotb_run import Design, run_cocotb
from ncdc_sim.runner import HDL
from ncdc_sim.tools import SIMULATORS


@pytest.mark.parametrize("simulator", cases(SIMULATORS, longer=["verilator"]))
@pytest.mark.parametrize("bench", [avalon_checker, axi_checker, stream_checker])
def test_rules(bench, simulator):
    name, four_states = bench.__name__.rpartition(".")[2], simulator == "icarus"
    log = run_cocotb(Design(name, (HDL / f"{name}.v").read_text()), name, simulator,
                     four_states=four_states)
    rules = [line.split()[2] for line in log.splitlines()
             if line.startswith(("AVALON-ERROR", "AXI-ERROR"))]
    assert rules == [rule for rule, _ in bench.VIOLATIONS + bench.UNKNOWN * four_states]
