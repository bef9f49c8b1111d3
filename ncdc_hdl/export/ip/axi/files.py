"""All files that ``ncdc generate --bus axi`` writes, without the drivers."""

from ncdc_hdl.export.ip.axi.component import IP_XACT, component_xml
from ncdc_hdl.export.ip.axi.device_tree import ModuleResources, device_tree
from ncdc_hdl.export.verilog.axi_cover import AXI_SYSTEM, axi_name, axi_verilog
from ncdc_hdl.export.waivers import SYSTEM_WAIVERS, verilator_config

__all__ = ["axi_files"]


def axi_files(top, name=None):
    """Text of the files of an :class:`ncdc_hdl.axi.top.AxiTop`, by file name.

    ``name``: of its module, by default that of :func:`axi_name`.
    """
    waivers = SYSTEM_WAIVERS if axi_name(top) == AXI_SYSTEM else None
    name, verilog = name or axi_name(top), axi_verilog(top, name)
    return {f"{name}.v": verilog, f"{name}.vlt": verilator_config(name, waivers),
            IP_XACT: component_xml(verilog, name, top.descriptor),
            f"{name}.dtsi": device_tree(
            name, ModuleResources(register_bytes=4 << top.address_bits))}
