"""The memory model in Verilog, under both simulators."""

import pytest

from ncdc_sim.cocotb_run import Design, run_cocotb
from ncdc_sim.memories import MEMORIES, MemoryTiming, memory_timing
from ncdc_sim.runner import HDL
from ncdc_sim.tools import SIMULATORS

TEXT = (HDL / "avalon_memory.v").read_text()
DESIGN = Design("avalon_memory", TEXT.replace("parameter PORTS = 1", "parameter PORTS = 2")
                .replace("parameter BYTES = 65536", "parameter BYTES = 4096"))


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("memory", [
    "ideal", "sdram", "hostile", MemoryTiming(latency=(9, 9), max_pending=1)], ids=str)
def test_memory(memory, simulator):
    run_cocotb(DESIGN, "avalon_memory", simulator, seed=3,
               **memory_timing(memory).plusargs(data_width=32, ports=2))


def test_settings_of_the_presets():
    assert MEMORIES["ideal"].plusargs(32, 3)["rate"] == 4 * 256
    assert MEMORIES["sdram"].plusargs(32, 3)["rate"] == 205
    assert MEMORIES["sdram"].plusargs(128, 1)["rate"] == 51
    assert MEMORIES["ddr3"].plusargs(32, 1) == {
        "latency_min": 20, "latency_max": 30, "rate": 819, "granule": 4, "wait_chance": 0,
        "max_pending": 16}
