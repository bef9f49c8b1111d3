"""The first screen of ``ncdc.v``: what it is, what it was made from, its ports by interface."""

import textwrap
from importlib.metadata import version

from ncdc_hdl.corrector import Corrector
from ncdc_hdl.export.verilog.convert import convert
from ncdc_model.hardware import Hardware

__all__ = ["TOP", "corrector_verilog", "verilog_of"]

TOP = "ncdc"

# What each port is for, by interface; of one that comes several times, by the interface's kind.
_CLOCK = {"clk": "the only clock; all ports belong to it", "rst": "synchronous, active high",
          "memory_rst": "the memory forgets what it owes"}
_AGENT = {
    "address": "word address, see docs/registers.md",
    "read": "read strobe, held while waitrequest",
    "write": "write strobe, held while waitrequest", "writedata": "word to write",
    "readdata": "word read, valid with readdatavalid", "readdatavalid": "one clock per read",
    "waitrequest": "low in the clock that accepts an access"}
_READ_HOST = {
    "address": "byte address of a burst, on a word",
    "read": "asks for a burst, held in waitrequest",
    "burstcount": "words of the burst", "waitrequest": "the memory takes no command now",
    "readdata": "words in the order asked for",
    "readdatavalid": "a word has come; it is not refused"}
_WRITE_HOST = {
    "address": "byte address of a burst, on a word",
    "write": "a word of a burst, held in waitrequest",
    "burstcount": "words of the burst, constant in it",
    "writedata": "pixels as OUTPUT_FORMAT has them",
    "byteenable": "bytes of the word that count",
    "waitrequest": "the memory takes no word now"}
_STREAM = {
    "valid": "a group of pixels is there, held until ready", "ready": "it is taken in this clock",
    "data": "24 bits a pixel, red on top, leftmost lowest",
    "startofpacket": "first group of a frame", "endofpacket": "last group of a frame"}
_OTHER = {
    "irq": "high while STATUS.DONE and IRQ_ENABLE",
    "camera_rows": "rows of the raw frame in memory, for FOLLOW",
    "front_end_idle": "the network rests: its clock may stop"}
_INTERFACES = (
    ("clock and reset", ("clk", "rst", "memory_rst"), _CLOCK),
    ("registers: Avalon-MM agent, 32 bits", "csr_", _AGENT),
    ("raw frame: Avalon-MM burst read host", "read0_", _READ_HOST),
    ("raw frame, second row of a window: Avalon-MM burst read host", "read1_", _READ_HOST),
    ("raw frame, third row of a window: Avalon-MM burst read host", "read2_", _READ_HOST),
    ("corrected frame: Avalon-MM burst write host", "write_", _WRITE_HOST),
    ("corrected frame: Avalon-ST video source", "stream_", _STREAM),
    ("status", ("irq", "camera_rows", "front_end_idle"), _OTHER),
)


def corrector_verilog(descriptor, hardware=Hardware()):
    """:func:`verilog_of` the :class:`ncdc_hdl.corrector.Corrector` of ``descriptor``.

    Errors raised: as of that class.
    """
    return verilog_of(Corrector(descriptor, hardware))


def verilog_of(corrector):
    """Verilog text of the corrector, module ``ncdc``; identical text for identical input."""
    descriptor, g = corrector.descriptor, corrector.descriptor.geometry
    command = " ".join(["ncdc generate NET.toml -o DIR", *corrector.hardware.options(g)])
    header = [
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
        f"Latency: the first window is asked for {corrector.start_latency} clocks after a frame's "
        f"start; a pixel leaves",
        f"{corrector.end_latency} clocks after its window has come. Every distinct module stands "
        f"here once, the top first,",
        "each below a line with its source, what it does and its latency in clocks."]
    return convert(corrector, TOP, header, _port_lines)


def _port_lines(head, ports):
    """The port list of the corrector by interface, with a comment for each port.

    Raises
    ------
    ValueError
        If a port belongs to no interface.
    """
    left = {name: port for name, *port in ports}
    groups = []
    for title, which, texts in _INTERFACES:
        prefix = which if isinstance(which, str) else ""
        names = ([prefix + name for name in texts] if prefix else list(which))
        found = [(name, *left.pop(name), texts[name.removeprefix(prefix)])
                 for name in names if name in left]
        if found:
            groups.append((title, found))
    if left:
        raise ValueError(f"the ports {', '.join(left)} belong to no interface")
    last = groups[-1][1][-1][0]
    lines = [f"module {head} ("]
    for title, found in groups:
        lines.append(f"  // {title}")
        for name, wire, kind, initial, text in found:
            width = f"[{wire.width - 1}:0]" if wire.width > 1 else ""
            end = "" if name == last else ","
            port = f"  {wire.port:<6} {kind:<4} {width:>7} {name}{initial}{end}"
            lines.append(f"{port:<48} // {text}")
    return [*lines, ");"]
