"""The memory model in Verilog, under both simulators."""

import pytest

from cases import cases
from cocotb_run import run_cocotb
from memory_model import memory_model
from ncdc_model.planner.memory_timing import memory_timing
from ncdc_sim.memory.timing import memory_settings
from ncdc_sim.tools import SIMULATORS


@pytest.mark.parametrize("simulator", cases(SIMULATORS, longer=["icarus"]))
@pytest.mark.parametrize("memory", cases(["ideal", "sdram", "ddr3@150", "hostile", "fixed:9:4"],
                                         longer=["ideal", "sdram", "ddr3@150"]))
def test_content_order_and_bandwidth(memory, simulator):
    run_cocotb(memory_model(), "avalon_memory", simulator, seed=3, bandwidth=memory == "ideal",
               memory=memory_settings(memory_timing(memory), data_width=32, ports=2))


def test_settings():
    def settings(name, width, ports):
        return memory_settings(memory_timing(name), width, ports)
    assert settings("ideal", 32, 3)["rate"] == 4 * 256
    assert settings("fixed:100:4", 32, 1)["rate"] == 256
    assert settings("fixed:100:4", 128, 1)["rate"] == 64
    assert settings("hostile", 32, 1) == {
        "dram": 0, "latency_min": 1, "latency_max": 60, "rate": 384, "granule": 1,
        "wait_probability": 128, "max_pending": 4}
    ddr3 = settings("ddr3@150", 128, 1)
    assert (ddr3["ratio_mul"], ddr3["ratio_div"], ddr3["controller_clocks"]) == (8, 3, 16)
    assert (ddr3["bank_bits"], ddr3["column_bits"], ddr3["access_bits"], ddr3["word_bits"]) == (
        3, 11, 4, 4)
