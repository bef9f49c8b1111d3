"""The corrector as a component of Platform Designer (Qsys): its ``_hw.tcl``."""

from importlib.metadata import version

from amaranth.hdl import Shape
from amaranth.lib.wiring import Out

from ncdc_hdl.export.verilog import TOP

__all__ = ["COMPONENT", "hw_tcl", "interfaces"]

COMPONENT = "ncdc"
_HOST = {"addressUnits": "SYMBOLS", "burstcountUnits": "WORDS", "linewrapBursts": "false",
         "burstOnBurstBoundariesOnly": "false", "doStreamReads": "false",
         "doStreamWrites": "false"}


def interfaces(corrector):
    """Interfaces of the corrector's ports: {name: (kind, direction, {port: (role, width)})}.

    Names as in Platform Designer; kinds clock, reset, avalon, avalon_streaming, interrupt,
    conduit; direction end or start. Every port of the Verilog is in exactly one of them.
    """
    found = {"clock": ("clock", "end", {"clk": ("clk", 1)}),
             "reset": ("reset", "end", {"rst": ("reset", 1)})}
    for port, member in corrector.signature.members.items():
        prefix, _, role = port.partition("_")
        name, kind, direction, role = _place(prefix, role, port)
        _, _, ports = found.setdefault(name, (kind, direction, {}))
        ports[port] = (role, Shape.cast(member.shape).width)
    return found


def _place(prefix, role, port):
    if prefix == "csr":
        return "csr", "avalon", "end", role
    if prefix.startswith("read") or prefix == "write":
        return prefix, "avalon", "start", role
    if prefix == "stream":
        return "stream", "avalon_streaming", "start", role
    if port == "memory_rst":
        return "memory_reset", "reset", "end", "reset"
    if port == "irq":
        return "irq", "interrupt", "end", "irq"
    return port, "conduit", "end", "export"


def hw_tcl(corrector):
    """Text of ``ncdc_hw.tcl`` for the :class:`~ncdc_hdl.corrector.Corrector`, Quartus 16.1 on.

    Beside the Verilog it names what the Nios tools put into ``system.h``: the number of neurons,
    the sizes of the pictures and the digest of the descriptor.
    """
    descriptor = corrector.descriptor
    g = descriptor.geometry
    lines = [
        "# Component of Platform Designer: NCDC, camera distortion corrector.",
        "package require -exact qsys 16.1", "",
        *(f"set_module_property {key} {_quote(value)}" for key, value in (
            ("NAME", COMPONENT), ("VERSION", version("ncdc")), ("GROUP", "Video"),
            ("DISPLAY_NAME", "NCDC camera distortion corrector"), ("AUTHOR", "NCDC"),
            ("DESCRIPTION", f"{g.distorted_width}x{g.distorted_height} raw Bayer frame to "
             f"{g.corrected_width}x{g.corrected_height} corrected pixels"),
            ("EDITABLE", "false"), ("INSTANTIATE_IN_SYSTEM_MODULE", "true"))), "",
    ]
    for fileset in ("QUARTUS_SYNTH", "SIM_VERILOG"):
        lines += [f'add_fileset {fileset} {fileset} "" ""',
                  f"set_fileset_property {fileset} TOP_LEVEL {TOP}",
                  f"add_fileset_file {TOP}.v VERILOG PATH {TOP}.v TOP_LEVEL_FILE"]
    lines.append("")
    for name, (kind, direction, ports) in interfaces(corrector).items():
        lines.append(f"add_interface {name} {kind} {direction}")
        lines += [f"set_interface_property {name} {key} {value}"
                  for key, value in _properties(name, kind, direction, corrector).items()]
        for port, (role, width) in ports.items():
            flow = "Input" if port in ("clk", "rst") else \
                "Output" if corrector.signature.members[port].flow is Out else "Input"
            lines.append(f"add_interface_port {name} {port} {role} {flow} {width}")
        lines.append("")
    macros = {"HIDDEN_NEURONS": descriptor.hidden_neurons,
              "CORRECTED_WIDTH": g.corrected_width, "CORRECTED_HEIGHT": g.corrected_height,
              "DISTORTED_WIDTH": g.distorted_width, "DISTORTED_HEIGHT": g.distorted_height,
              "DIGEST": f"0x{int(descriptor.digest[:8], 16):08X}u",
              "REGISTERS": len(corrector.registers.table)}
    lines += [f"set_module_assignment embeddedsw.CMacro.{name} {value}"
              for name, value in macros.items()]
    return "\n".join(lines) + "\n"


def _properties(name, kind, direction, corrector):
    if kind == "clock":
        return {}
    if kind == "reset":
        return {"associatedClock": "clock", "synchronousEdges": "BOTH"}
    own = {"associatedClock": "clock", "associatedReset": "reset"}
    if kind == "avalon" and direction == "end":
        # One read at a time: the agent holds waitrequest until it has answered.
        return own | {"addressUnits": "WORDS", "maximumPendingReadTransactions": 1,
                      "readLatency": 0, "readWaitTime": 0, "writeWaitTime": 0}
    if kind == "avalon":
        return own | _HOST
    if kind == "avalon_streaming":
        width = corrector.signature.members["stream_data"].shape
        symbols = Shape.cast(width).width // 8
        # Red first; of several pixels, the leftmost first, which is in the lowest bits.
        return own | {"dataBitsPerSymbol": 8, "symbolsPerBeat": symbols,
                      "firstSymbolInHighOrderBits": str(symbols == 3).lower(),
                      "readyLatency": int(corrector.hardware.video == "vip")}
    if kind == "interrupt":
        return own | {"associatedAddressablePoint": "csr"}
    return own


def _quote(value):
    """``value`` as one word of Tcl."""
    return "{" + value + "}" if set(value) & set(' "$[]') else value
