"""The Verilog of the AXI4-Stream source of samples, next to ``cocotbext-axi``."""

import pytest

from cocotb_run import design_of, run_cocotb
from ncdc_hdl.camera.axis_source import AxisSource

pytestmark = pytest.mark.longer


@pytest.mark.parametrize("count,bits,gap,simulator", [
    (1, 12, .3, "icarus"), (2, 10, .4, "verilator"), (4, 16, 0, "icarus"), (4, 8, .2, "icarus")])
def test_axis_source(count, bits, gap, simulator):
    run_cocotb(design_of(AxisSource(count, bits), f"axis_{count}_{bits}"), "axis_source",
               simulator, count=count, bits=bits, gap=gap)
