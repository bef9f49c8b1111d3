"""Files for designs with AXI: the Verilog, its description in IP-XACT, Linux's device tree."""

from ncdc_hdl.export.ip.axi.files import axi_files

__all__ = ["axi_files"]
