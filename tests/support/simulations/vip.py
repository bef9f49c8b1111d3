"""A module with Intel's video packets before the benches of whole frames."""

import re

from ncdc_hdl.export.verilog import TOP
from simulations import HDL

__all__ = ["unpacked"]

_PORT = re.compile(r"^\s*(input|output)\s+(?:reg\s+|wire\s+)?(?:\[(\d+):0\]\s*)?(\w+)")
_CORE = f"{TOP}_packets"


def unpacked(verilog):
    """``verilog`` with a module ``ncdc`` around the one in it, whose stream is a plain one.

    ``vip_unpacker.v`` unpacks and checks the packets of the inner module.
    """
    head, _, body = verilog.partition(f"module {TOP} (")
    text = f"{head}module {_CORE} ({body}"
    ports = [match.groups() for line in body[:body.index(");")].splitlines()
             if (match := _PORT.match(line))]
    lines = [f"module {TOP} ("]
    lines += [f"    {flow} wire [{high or 0}:0] {name}," for flow, high, name in ports]
    lines[-1] = lines[-1].rstrip(",") + ");"
    streamed = ("valid", "ready", "data", "startofpacket", "endofpacket")
    for name in streamed:
        lines.append(f"    wire [{23 if name == 'data' else 0}:0] core_{name};")
    inner = [f".{name}({name.replace('stream_', 'core_')})" for _, _, name in ports]
    joined = [f".{prefix}{name}({wires}_{name})" for name in streamed
              for prefix, wires in (("in_", "core"), ("", "stream"))]
    lines += [f"    {_CORE} core ({', '.join(inner)});",
              f"    vip_unpacker sink (.clk(clk), .rst(rst), {', '.join(joined)});", "endmodule"]
    return "\n".join([text, (HDL / "vip_unpacker.v").read_text(), *lines]) + "\n"
