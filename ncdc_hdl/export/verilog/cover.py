"""The first screen of ``ncdc.v``: purpose, origin, ports by interface."""

import textwrap
from functools import partial
from importlib.metadata import version

from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog.convert import convert
from ncdc_hdl.export.verilog.port_list import (
    AGENT,
    CLOCK,
    READ_HOST,
    STREAM,
    WRITE_HOST,
    port_lines,
)
from ncdc_spec.hardware import Hardware

__all__ = ["STATUS", "TOP", "corrector_header", "corrector_verilog", "name_option",
           "verilog_of"]

TOP = "ncdc"

STATUS = {
    "irq": "high while STATUS.DONE and IRQ_ENABLE",
    "camera_rows": "rows of the raw frame in memory, for FOLLOW",
    "front_end_idle": "the network is idle: its clock may stop"}
_INTERFACES = (
    ("clock and reset", ("clk", "rst", "memory_rst"), CLOCK),
    ("registers: Avalon-MM agent, 32 bits", "csr_", AGENT),
    ("raw frame: Avalon-MM burst read host", "read0_", READ_HOST),
    ("raw frame, second row of a window: Avalon-MM burst read host", "read1_", READ_HOST),
    ("raw frame, third row of a window: Avalon-MM burst read host", "read2_", READ_HOST),
    ("corrected frame: Avalon-MM burst write host", "write_", WRITE_HOST),
    ("corrected frame: Avalon-ST video source", "stream_", STREAM),
    ("status", ("irq", "camera_rows", "front_end_idle"), STATUS),
)


def corrector_verilog(descriptor, hardware=Hardware()):
    """:func:`verilog_of` the :class:`ncdc_hdl.corrector.Corrector` of ``descriptor``.

    Errors raised: as in that class.
    """
    return verilog_of(Corrector(descriptor, hardware))


def verilog_of(corrector, name=TOP):
    """Verilog text of the corrector, module ``name``; identical text for identical input."""
    return convert(corrector, name, corrector_header(corrector, name_option(name, TOP)),
                   partial(port_lines, interfaces=_INTERFACES))


def name_option(name, default):
    """The options of ``ncdc generate`` that give a module this name, as a list."""
    return [] if name == default else [f"--name {name}"]


def corrector_header(corrector, options=()):
    """Lines that open the Verilog of a corrector: generator, descriptor, latency.

    ``options``: of ``ncdc generate``, in addition to those of the hardware.
    """
    descriptor, g = corrector.descriptor, corrector.descriptor.geometry
    command = " ".join(["ncdc generate NET.toml -o DIR", *options, *corrector.hardware.options(g)])
    return [
        f"NCDC {version('ncdc')}: camera distortion corrector, made with Amaranth "
        f"{version('amaranth')}. Do not edit; it was made by",
        *textwrap.wrap(command, 90, initial_indent="    ", subsequent_indent="        ",
                       break_long_words=False, break_on_hyphens=False),
        f"from the descriptor {descriptor.digest}: {descriptor.hidden_neurons} hidden neurons, "
        f"{g.distorted_width}x{g.distorted_height} raw {g.bayer} samples to",
        f"{g.corrected_width}x{g.corrected_height} corrected pixels. After configuration the "
        f"registers hold that descriptor's values.",
        *([f"The network is evaluated at every {descriptor.nodes}th pixel of a row."]
          if descriptor.nodes > 1 else []),
        "",
        f"Latency: the first window is requested {corrector.start_latency} clocks after a frame's "
        f"start; a pixel leaves",
        f"{corrector.end_latency} clocks after its window has come. Every distinct module is "
        f"here once, the top first,",
        "each below a line with its source, what it does and its latency in clocks."]
