"""A self-checking test bench in Verilog, for any simulator."""

from ncdc_hdl.export.testbench.bench import bench_files
from ncdc_hdl.export.testbench.template import instantiation

__all__ = ["bench_files", "instantiation"]
