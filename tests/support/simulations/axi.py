"""A module with AXI ports between the Avalon ports of the benches of whole frames."""

from ncdc_sim.ports import ports_of
from simulations import HDL

__all__ = ["adapted"]

_BURST_WIDTH = 5        # of the Avalon ports: bursts of up to 16 words
_PLAIN = ("irq", "camera_rows", "front_end_idle", "sensor_clock", "sensor_frame_valid",
          "sensor_line_valid", "sensor_data", "scl_low", "sda_low", "scl", "sda")


def adapted(verilog, *, core, top, lines=None, pending=16):
    """Verilog with a module ``top`` whose Avalon ports reach the module ``core`` of ``verilog``.

    Memory, host and sink of the benches then serve AXI, through models that share no code with the
    gateware (``axi_memory.v``), with :mod:`axi_checker.v` on each port. An interrupt that comes
    while a write has no answer is an error.

    Parameters
    ----------
    verilog : str
        With AXI ports, of :func:`ncdc_hdl.export.verilog.axi_cover.axi_verilog`.
    core, top : str
    lines : int, optional
        Rows of the corrected picture, for the end of a packet, if there is a stream.
    pending : int
        Bursts of a direction without an end, at most.
    """
    ports = ports_of(verilog, core)
    readers = sorted({name.split("_")[2] for name in ports if name.startswith("m_axi_read")})
    bench = _Adapter(ports, core, top)
    bench.registers()
    for number, reader in enumerate(readers):
        bench.reader(reader, number, pending)
    if "m_axi_write_wdata" in ports:
        bench.writer(pending)
    if "m_axis_tdata" in ports:
        bench.stream(lines)
    for name in _PLAIN:
        if name in ports:
            bench.port(name, "output" if name in ("irq", "front_end_idle", "scl_low", "sda_low")
                       else "input", ports[name])
            bench.connect(name, name)
    sources = [(HDL / name).read_text() for name in ("axi_memory.v", "axi_checker.v")]
    return "\n".join([verilog, *sources, bench.text()])


class _Adapter:
    """Gathers the ports and the parts of the module between."""

    def __init__(self, ports, core, top):
        self.widths, self.core, self.top = ports, core, top
        self.declared, self.connected, self.body = [], [], []
        for name in ("clk", "rst", "memory_rst"):
            self.port(name, "input", 1)
        for name, value in (("aclk", "clk"), ("aresetn", "!memory_rst"), ("core_rst", "rst")):
            self.connect(name, value)

    def port(self, name, direction, width):
        size = f"[{width - 1}:0] " if width > 1 else ""
        self.declared.append(f"    {direction} wire {size}{name}")

    def connect(self, name, value):
        self.connected.append(f"        .{name}({value})")

    def wires(self, prefix):
        """Wires for all ports of the core that begin so, connected; their names without prefix."""
        found = [name for name in self.widths if name.startswith(prefix)]
        for name in found:
            self.body.append(f"    wire [{self.widths[name] - 1}:0] {name};")
            self.connect(name, name)
        return [name.removeprefix(prefix) for name in found]

    def registers(self):
        self.wires("s_axi_")
        bits = self.widths["s_axi_awaddr"] - 2
        for name, direction, width in (
                ("address", "input", bits), ("read", "input", 1), ("write", "input", 1),
                ("writedata", "input", 32), ("readdata", "output", 32),
                ("readdatavalid", "output", 1), ("waitrequest", "output", 1)):
            self.port(f"csr_{name}", direction, width)
        lite = ("awaddr", "araddr", "wdata", "awvalid", "wvalid", "arvalid", "rready", "bready",
                "awready", "wready", "arready", "rvalid", "bvalid", "rdata", "rresp", "bresp")
        avalon = ("address", "read", "write", "writedata", "readdata", "readdatavalid",
                  "waitrequest")
        self.body.append(
            f"    assign s_axi_wstrb = 4'hF, s_axi_awprot = 0, s_axi_arprot = 0;\n"
            f"    axi_lite_host #(.ADDRESS_BITS({bits})) registers (\n"
            f"        .clk(clk), .memory_rst(memory_rst),\n        "
            + ", ".join([*(f".{name}(csr_{name})" for name in avalon),
                         *(f".{name}(s_axi_{name})" for name in lite)]) + ");")

    def reader(self, reader, number, pending):
        prefix, width = f"m_axi_{reader}_", self.widths[f"m_axi_{reader}_rdata"]
        self.wires(prefix)
        for name, direction, size in (
                ("address", "output", 32), ("read", "output", 1),
                ("burstcount", "output", _BURST_WIDTH), ("waitrequest", "input", 1),
                ("readdata", "input", width), ("readdatavalid", "input", 1)):
            self.port(f"{reader}_{name}", direction, size)
        channels = ("araddr", "arlen", "arvalid", "arready", "rdata", "rresp", "rlast", "rvalid")
        avalon = ("address", "read", "burstcount", "waitrequest", "readdata", "readdatavalid")
        self.body.append(
            f"    assign {prefix}rid = 0;\n"
            f"    axi_read_memory #(.DATA_WIDTH({width}), .BURST_WIDTH({_BURST_WIDTH}), "
            f".NUMBER({number})) memory_{reader} (\n        .clk(clk), .memory_rst(memory_rst), "
            + ", ".join([*(f".{name}({prefix}{name})" for name in channels),
                         *(f".{name}({reader}_{name})" for name in avalon)]) + ");")
        self._checker(f"axi_{reader}", prefix, width, pending)

    def writer(self, pending):
        prefix, width = "m_axi_write_", self.widths["m_axi_write_wdata"]
        self.wires(prefix)
        for name, direction, size in (
                ("address", "output", 32), ("write", "output", 1),
                ("burstcount", "output", _BURST_WIDTH), ("writedata", "output", width),
                ("byteenable", "output", width // 8), ("waitrequest", "input", 1)):
            self.port(f"write_{name}", direction, size)
        channels = ("awaddr", "awlen", "awvalid", "awready", "wdata", "wstrb", "wlast", "wvalid",
                    "wready", "bvalid", "bresp", "bready")
        avalon = ("address", "write", "burstcount", "writedata", "byteenable", "waitrequest")
        self.body.append(
            f"    assign {prefix}bid = 0;\n    wire unanswered;\n"
            f"    axi_write_memory #(.DATA_WIDTH({width}), .BURST_WIDTH({_BURST_WIDTH})) "
            f"memory_write (\n        .clk(clk), .memory_rst(memory_rst), "
            f".unanswered(unanswered), "
            + ", ".join([*(f".{name}({prefix}{name})" for name in channels),
                         *(f".{name}(write_{name})" for name in avalon)]) + ");")
        self._checker("axi_write", prefix, width, pending)
        if self.top == "ncdc":      # of a camera, frames are written while others are announced
            self.body.append(
                "    reg irq_was = 0;\n"
                "    always @(posedge clk) begin\n"
                "        if (irq && !irq_was && unanswered)\n"
                '            $display("AXI-ERROR axi_write done-early %0t", $time);\n'
                "        irq_was <= irq;\n"
                "    end")

    def _checker(self, name, prefix, width, pending):
        """A checker on the core's ports that begin with ``prefix``; others are tied to 0."""
        read = ("arid", "arlock", "arvalid", "arready", "araddr", "arlen", "arsize", "arburst",
                "rid", "rlast", "rvalid", "rready", "rresp", "rdata")
        write = ("awid", "awlock", "awvalid", "awready", "awaddr", "awlen", "awsize", "awburst",
                 "wdata", "wstrb", "wlast", "wvalid", "wready", "bid", "bvalid", "bready", "bresp")
        there = {name for name in (*read, *write) if prefix + name in self.widths}
        idle = {"rdata": f"{width}'d0", "wdata": f"{width}'d0", "wstrb": f"{width // 8}'d0",
                "araddr": "32'd0", "awaddr": "32'd0", "arlen": "8'd0", "awlen": "8'd0",
                "arsize": "3'd0", "awsize": "3'd0", "arburst": "2'd0", "awburst": "2'd0",
                "rresp": "2'd0", "bresp": "2'd0"}
        self.body.append(
            f'    axi_checker #(.NAME("{name}"), .DATA_WIDTH({width}), .PENDING({pending})) '
            f"checker_of_{name} (\n        .clk(clk), .resetn(!memory_rst), .errors(), .reads(), "
            ".writes(), .words_read(), .words_written(),\n        "
            + ", ".join(f".{port}({prefix + port if port in there else idle.get(port, 1)})"
                        .replace("(1)", "(1'b0)") for port in (*read, *write)) + ");")

    def stream(self, lines):
        width = self.widths["m_axis_tdata"]
        self.wires("m_axis_")
        for name, direction, size in (
                ("valid", "output", 1), ("ready", "input", 1), ("data", "output", width),
                ("startofpacket", "output", 1), ("endofpacket", "output", 1)):
            self.port(f"stream_{name}", direction, size)
        # Red, blue, green from the top; the bench wants red, green, blue.
        pixels = ", ".join(f"m_axis_tdata[{k + 16} +: 8], m_axis_tdata[{k} +: 8], "
                           f"m_axis_tdata[{k + 8} +: 8]" for k in range(width - 24, -1, -24))
        self.body.append(
            f"    reg [15:0] line = 0;\n"
            f"    assign stream_valid = m_axis_tvalid, m_axis_tready = stream_ready;\n"
            f"    assign stream_data = {{{pixels}}};\n"
            f"    assign stream_startofpacket = m_axis_tuser;\n"
            f"    assign stream_endofpacket = m_axis_tlast && line_now == {lines - 1};\n"
            f"    wire [15:0] line_now = m_axis_tuser ? 0 : line;\n"
            f"    always @(posedge clk)\n"
            f"        if (m_axis_tvalid && m_axis_tready)\n"
            f"            line <= line_now + m_axis_tlast;")

    def text(self):
        return "\n".join([
            f"module {self.top} (", ",\n".join(self.declared), ");", *self.body,
            f"    {self.core} core (", ",\n".join(self.connected), "    );", "endmodule", ""])
