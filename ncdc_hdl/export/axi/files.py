"""Every file that ``ncdc generate --bus axi`` writes beside the drivers."""

from ncdc_hdl.export.verilog.axi_cover import AXI_SYSTEM, axi_name, axi_verilog
from ncdc_hdl.export.waivers import SYSTEM_WAIVERS, verilator_config

__all__ = ["axi_files"]


def axi_files(top):
    """Text of what belongs to an :class:`ncdc_hdl.axi.top.AxiTop`, by file name."""
    name = axi_name(top)
    waivers = SYSTEM_WAIVERS if name == AXI_SYSTEM else None
    return {f"{name}.v": axi_verilog(top), f"{name}.vlt": verilator_config(name, waivers)}
