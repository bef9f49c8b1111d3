"""The memory model in Verilog as a design of its own, for the cocotb benches."""

from cocotb_run import Design
from ncdc_sim.runner import HDL

__all__ = ["memory_model"]


def memory_model(width=32, planted=("", "")):
    """The model with two read ports and 128 KB.

    ``planted``: a text of dram_timing.v and what replaces it.
    """
    timing = (HDL / "dram_timing.v").read_text()
    assert planted[0] in timing
    model = ((HDL / "avalon_memory.v").read_text()
             .replace("parameter PORTS = 1", "parameter PORTS = 2")
             .replace("parameter DATA_WIDTH = 32", f"parameter DATA_WIDTH = {width}")
             .replace("parameter BYTES = 65536", "parameter BYTES = 131072"))
    return Design("avalon_memory", timing.replace(*planted, 1) + model, ("dram_timing",))
