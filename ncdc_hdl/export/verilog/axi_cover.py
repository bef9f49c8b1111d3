"""The first screen of ``ncdc_axi.v`` and ``ncdc_system_axi.v``."""

from functools import partial

from ncdc_hdl.export.verilog.convert import convert
from ncdc_hdl.export.verilog.cover import STATUS, TOP, corrector_header, name_option
from ncdc_hdl.export.verilog.port_list import (
    AXI_CLOCK,
    AXI_LITE,
    AXI_READ,
    AXI_VIDEO,
    AXI_WRITE,
    port_lines,
)
from ncdc_hdl.export.verilog.system_cover import SYSTEM, pins, system_header

__all__ = ["AXI_SYSTEM", "AXI_TOP", "axi_name", "axi_verilog"]

AXI_TOP, AXI_SYSTEM = f"{TOP}_axi", f"{SYSTEM}_axi"

_INTERFACES = (
    ("clock and reset", tuple(AXI_CLOCK), AXI_CLOCK),
    ("registers: AXI4-Lite subordinate, 32 bits", "s_axi_", AXI_LITE),
    ("raw frame: AXI4 manager that reads", "m_axi_read0_", AXI_READ),
    ("raw frame, second row of a window: AXI4 manager that reads", "m_axi_read1_", AXI_READ),
    ("raw frame, third row of a window: AXI4 manager that reads", "m_axi_read2_", AXI_READ),
    ("frames to memory: AXI4 manager that writes", "m_axi_write_", AXI_WRITE),
    ("corrected frame: AXI4-Stream video", "m_axis_", AXI_VIDEO),
)


def axi_name(top):
    """Name of the module of an :class:`ncdc_hdl.axi.top.AxiTop`."""
    return AXI_SYSTEM if hasattr(top.core, "corrector") else AXI_TOP


def axi_verilog(top, name=None):
    """Verilog text of an :class:`ncdc_hdl.axi.top.AxiTop`; identical text for identical input.

    ``name``: of its module, by default that of :func:`axi_name`.
    """
    system = hasattr(top.core, "corrector")
    options = name_option(name or axi_name(top), axi_name(top))
    header = (system_header if system else corrector_header)(top.core, options)
    plain = pins(top.core.camera) if system else (("status", tuple(STATUS), STATUS),)
    return convert(top, name or axi_name(top), header,
                   partial(port_lines, interfaces=(*_INTERFACES, *plain)))
