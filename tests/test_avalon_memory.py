"""The memory model in Verilog, under both simulators."""

from dataclasses import replace

import pytest

from ncdc_model.memory_timing import LatencyMemory, ddr3, memory_timing, sdram
from ncdc_sim.cocotb_run import Design, run_cocotb
from ncdc_sim.memories import memory_settings
from ncdc_sim.runner import HDL
from ncdc_sim.tools import SIMULATORS, SimulationError


def design(ports=2, width=32, planted=None):
    """The model with 4 KB; ``planted``: a text and what to put in its place, in dram_timing.v."""
    timing = (HDL / "dram_timing.v").read_text()
    if planted:
        assert planted[0] in timing
        timing = timing.replace(*planted)
    return Design("avalon_memory", timing + (HDL / "avalon_memory.v").read_text()
                  .replace("parameter PORTS = 1", f"parameter PORTS = {ports}")
                  .replace("parameter DATA_WIDTH = 32", f"parameter DATA_WIDTH = {width}")
                  .replace("parameter BYTES = 65536", "parameter BYTES = 131072"))


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("memory", ["ideal", "sdram", "ddr3", "ddr3@150", "hostile", "fixed:9:4"])
def test_content_and_order(memory, simulator):
    memory = memory_timing(memory)
    run_cocotb(design(), "avalon_memory", simulator, seed=3,
               memory=memory_settings(memory, data_width=32, ports=2))
