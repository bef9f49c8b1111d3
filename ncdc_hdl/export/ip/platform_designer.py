"""Modules as components of Platform Designer (Qsys): their ``_hw.tcl``."""

from dataclasses import dataclass
from importlib.metadata import version

from amaranth.hdl import Shape
from amaranth.lib.wiring import Out

from ncdc_hdl.export.verilog import TOP
from ncdc_hdl.export.verilog.system_cover import SYSTEM
from ncdc_hdl.link.top import PACKETISER
from ncdc_spec.camera_port import AVALON_ST, VIP

__all__ = ["COMPONENT", "hw_tcl", "interfaces", "packetiser_hw_tcl", "system_hw_tcl"]

COMPONENT = "ncdc"
_HOST = {"addressUnits": "SYMBOLS", "burstcountUnits": "WORDS", "linewrapBursts": "false",
         "burstOnBurstBoundariesOnly": "false", "doStreamReads": "false",
         "doStreamWrites": "false"}
# Ports outside the buses of memory and registers: a conduit for several, by their prefix.
_CONDUITS = {"sensor": "sensor", "scl": "i2c", "sda": "i2c", "usb": "usb"}


@dataclass(frozen=True)
class _Component:
    """Description of a component.

    Parameters
    ----------
    top : str
        Name of the module and of the component.
    title, text : str
    macros : dict
        Values that the Nios tools put into ``system.h``.
    """
    top: str
    title: str
    text: str
    macros: dict


def interfaces(core):
    """Interfaces of a module's ports: {name: (kind, direction, {port: (role, width)})}.

    Names as in Platform Designer; kinds clock, reset, avalon, avalon_streaming, interrupt,
    conduit; direction end or start. Every port of the Verilog is in exactly one of them.
    """
    found = {"clock": ("clock", "end", {"clk": ("clk", 1)}),
             "reset": ("reset", "end", {"rst": ("reset", 1)})}
    for port, member in core.signature.members.items():
        prefix, _, role = port.partition("_")
        name, kind, direction, role = (
            _camera(role) if prefix == "sensor" and _video(core) else _role(prefix, role, port))
        _, _, ports = found.setdefault(name, (kind, direction, {}))
        ports[port] = (role, Shape.cast(member.shape).width)
    return found


def _video(core):
    """The camera's samples come as Avalon-ST."""
    return core.camera.kind in (AVALON_ST, VIP)


def _camera(role):
    """Interface of a port of the camera's stream, which has a clock of its own."""
    if role == "clock":
        return "sensor_clock", "clock", "end", "clk"
    return "sensor", "avalon_streaming", "end", role


def _role(prefix, role, port):
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
    if prefix in _CONDUITS:
        return _CONDUITS[prefix], "conduit", "end", port
    return port, "conduit", "end", "export"


def hw_tcl(corrector, name=TOP):
    """Text of ``<name>_hw.tcl`` for the :class:`~ncdc_hdl.corrector.Corrector`, Quartus 16.1 on.

    It names the Verilog, and the Nios tools' values of ``system.h``: the number of neurons,
    the sizes of the pictures and the digest of the descriptor.
    """
    g = corrector.descriptor.geometry
    return _tcl(corrector, _Component(
        name, "NCDC camera distortion corrector",
        f"{g.distorted_width}x{g.distorted_height} raw Bayer frame to "
        f"{g.corrected_width}x{g.corrected_height} corrected pixels", _macros(corrector)))


def system_hw_tcl(system, name=SYSTEM):
    """Text of ``<name>_hw.tcl`` for a :class:`~ncdc_hdl.system.System`, or one with
    USB."""
    g = system.descriptor.geometry
    return _tcl(system, _Component(
        name, "NCDC camera system",
        f"camera of {g.distorted_width}x{g.distorted_height}, stores of frames, correction to "
        f"{g.corrected_width}x{g.corrected_height}", _macros(system.corrector)))


def packetiser_hw_tcl(packetiser, name=PACKETISER):
    """Text of ``<name>_hw.tcl`` for a
    :class:`~ncdc_hdl.link.top.PacketiserTop`."""
    return _tcl(packetiser, _Component(
        name, "NCDC packetiser", "frames in memory as Ethernet packets", {}))


def _macros(corrector):
    descriptor, g = corrector.descriptor, corrector.descriptor.geometry
    return {"HIDDEN_NEURONS": descriptor.hidden_neurons,
            "CORRECTED_WIDTH": g.corrected_width, "CORRECTED_HEIGHT": g.corrected_height,
            "DISTORTED_WIDTH": g.distorted_width, "DISTORTED_HEIGHT": g.distorted_height,
            "DIGEST": f"0x{int(descriptor.digest[:8], 16):08X}u",
            "REGISTERS": len(corrector.registers.table)}


def _tcl(core, about):
    lines = [
        f"# Component of Platform Designer: {about.title[:4]}, {about.title[5:]}.",
        "package require -exact qsys 16.1", "",
        *(f"set_module_property {key} {_quote(value)}" for key, value in (
            ("NAME", about.top), ("VERSION", version("ncdc")), ("GROUP", "Video"),
            ("DISPLAY_NAME", about.title), ("AUTHOR", "NCDC"), ("DESCRIPTION", about.text),
            ("EDITABLE", "false"), ("INSTANTIATE_IN_SYSTEM_MODULE", "true"))), "",
    ]
    for fileset in ("QUARTUS_SYNTH", "SIM_VERILOG"):
        lines += [f'add_fileset {fileset} {fileset} "" ""',
                  f"set_fileset_property {fileset} TOP_LEVEL {about.top}",
                  f"add_fileset_file {about.top}.v VERILOG PATH {about.top}.v TOP_LEVEL_FILE"]
    lines.append("")
    for name, (kind, direction, ports) in interfaces(core).items():
        lines.append(f"add_interface {name} {kind} {direction}")
        lines += [f"set_interface_property {name} {key} {value}"
                  for key, value in _properties(name, kind, direction, core).items()]
        for port, (role, width) in ports.items():
            flow = "Input" if port in ("clk", "rst") else \
                "Output" if core.signature.members[port].flow is Out else "Input"
            lines.append(f"add_interface_port {name} {port} {role} {flow} {width}")
        lines.append("")
    lines += [f"set_module_assignment embeddedsw.CMacro.{name} {value}"
              for name, value in about.macros.items()]
    return "\n".join(lines).rstrip("\n") + "\n"


def _properties(name, kind, direction, core):
    if kind == "clock":
        return {}
    if kind == "reset":
        return {"associatedClock": "clock", "synchronousEdges": "BOTH"}
    own = {"associatedClock": "clock", "associatedReset": "reset"}
    if name == "sensor" and kind == "avalon_streaming":
        camera = core.camera
        return own | {"associatedClock": "sensor_clock", "dataBitsPerSymbol": camera.bits,
                      "symbolsPerBeat": camera.samples, "firstSymbolInHighOrderBits": "false",
                      "readyLatency": 0}
    if kind == "avalon" and direction == "end":
        # One read at a time: the agent holds waitrequest until it has answered.
        return own | {"addressUnits": "WORDS", "maximumPendingReadTransactions": 1,
                      "readLatency": 0, "readWaitTime": 0, "writeWaitTime": 0}
    if kind == "avalon":
        return own | _HOST
    if kind == "avalon_streaming":
        symbols = Shape.cast(core.signature.members["stream_data"].shape).width // 8
        if "stream_empty" in core.signature.members:
            # Bytes of a packet: the first one is highest.
            return own | {"dataBitsPerSymbol": 8, "symbolsPerBeat": symbols,
                          "firstSymbolInHighOrderBits": "true", "readyLatency": 0}
        # Red first; of several pixels, the leftmost first, which is in the lowest bits.
        return own | {"dataBitsPerSymbol": 8, "symbolsPerBeat": symbols,
                      "firstSymbolInHighOrderBits": str(symbols == 3).lower(),
                      "readyLatency": int(core.hardware.video == "vip")}
    if kind == "interrupt":
        return own | {"associatedAddressablePoint": "csr"}
    return own


def _quote(value):
    """``value`` as one word of Tcl."""
    return "{" + value + "}" if set(value) & set(' "$[]') else value
