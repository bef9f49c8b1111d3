"""The corrector as one self-contained Verilog file that reads like one written by hand."""

from ncdc_hdl.export.verilog.convert import convert
from ncdc_hdl.export.verilog.cover import TOP, corrector_verilog, verilog_of

__all__ = ["TOP", "corrector_verilog", "module_verilog", "verilog_of"]


def module_verilog(component, name, platform=None):
    """Verilog text of one Amaranth ``component`` as module ``name``, without a header.

    ``platform``: an Amaranth platform, which may have its own synchronisers; a simulation's has.
    """
    return convert(component, name, platform=platform)
