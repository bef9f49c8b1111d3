"""A system with a camera's stream of video for the bench of a parallel sensor."""

from ncdc_hdl.export.testbench.ports import ports_of_text
from ncdc_hdl.export.verilog.system_cover import SYSTEM
from ncdc_spec.camera_port import AXIS, VIP
from simulations import HDL

__all__ = ["from_pins"]

_CORE = f"{SYSTEM}_video"
_AXIS = {"tvalid": "valid", "tready": "ready", "tdata": "beat", "tuser": "first",
         "tlast": "row_end"}
_AVALON_ST = {"valid": "valid", "ready": "ready", "data": "beat", "startofpacket": "first",
              "endofpacket": "last"}


def from_pins(verilog, camera, size):
    """``verilog`` of a system for ``camera`` with a module ``ncdc_system`` around the one in it.

    It has a parallel sensor's pins, whose frames of ``size`` ``video_camera.v`` sends as video.
    """
    head, _, body = verilog.partition(f"module {SYSTEM} (")
    text = f"{head}module {_CORE} ({body}"
    ports = [port for port in ports_of_text(text, _CORE)
             if port.name == "sensor_clock" or not port.name.startswith("sensor_")]
    declared = [f"    {port.direction} wire {port.range} {port.name}" for port in ports]
    declared += ["    input wire sensor_frame_valid, sensor_line_valid",
                 "    input wire [11:0] sensor_data"]
    stream = _AXIS if camera.kind == AXIS else _AVALON_ST
    inner = [f".{port.name}({port.name})" for port in ports]
    inner += [f".sensor_{port}({wire})" for port, wire in stream.items()]
    if camera.kind != AXIS and camera.samples > 1:
        inner.append(f".sensor_empty({camera.samples.bit_length() - 1}'d0)")
    options = {"COUNT": camera.samples, "BITS": camera.bits, "PACKETS": int(camera.kind == VIP),
               "WIDTH": size[0], "HEIGHT": size[1]}
    return "\n".join([
        text, (HDL / "video_camera.v").read_text(),
        f"module {SYSTEM} (", ",\n".join(declared), ");",
        "    wire valid, ready, first, row_end, last;",
        f"    wire [{camera.samples * camera.bits - 1}:0] beat;",
        f"    video_camera #({', '.join(f'.{name}({value})' for name, value in options.items())})",
        "    camera (.clock(sensor_clock), .frame_valid(sensor_frame_valid),",
        "            .line_valid(sensor_line_valid), .data(sensor_data), .valid(valid),",
        "            .ready(ready), .beat(beat), .first(first), .row_end(row_end), .last(last));",
        f"    {_CORE} core ({', '.join(inner)});", "endmodule", ""])
