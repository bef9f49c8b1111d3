"""The protocol checkers in Verilog: every rule fires on a planted violation, under its own name."""

import pytest

import ncdc_sim.runner
import simulations
from benches import avalon_checker, axi_checker, stream_checker
from cases import cases
from cocotb_run import Design, run_cocotb
from ncdc_sim.tools import SIMULATORS

FOLDERS = {avalon_checker: ncdc_sim.runner.HDL, axi_checker: simulations.HDL,
           stream_checker: ncdc_sim.runner.HDL}


@pytest.mark.parametrize("simulator", cases(SIMULATORS, longer=["verilator"]))
@pytest.mark.parametrize("bench", FOLDERS)
def test_rules(bench, simulator):
    name, four_states = bench.__name__.rpartition(".")[2], simulator == "icarus"
    design = Design(name, (FOLDERS[bench] / f"{name}.v").read_text())
    log = run_cocotb(design, name, simulator, four_states=four_states)
    rules = [line.split()[2] for line in log.splitlines()
             if line.startswith(("AVALON-ERROR", "AXI-ERROR"))]
    assert rules == [rule for rule, _ in bench.VIOLATIONS + bench.UNKNOWN * four_states]
