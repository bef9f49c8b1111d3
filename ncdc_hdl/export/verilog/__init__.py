"""The corrector as one self-contained Verilog file that reads like one written by hand."""

from ncdc_hdl.export.verilog.convert import convert
from ncdc_hdl.export.verilog.cover import TOP, corrector_verilog, verilog_of

__all__ = ["TOP", "corrector_verilog", "module_verilog", "verilog_of"]


def module_verilog(component, name):
    """Verilog text of one Amaranth ``component`` as module ``name``, without a header."""
    return convert(component, name)
