"""A test bench that runs one frame through the generated Verilog and checks every pixel."""

import re
from importlib.resources import files

import numpy as np

from ncdc_hdl.export.testbench.ports import ports_of_text
from ncdc_model.correction import correct
from ncdc_spec.frames import (
    FrameAddresses,
    frame_bytes,
    output_format,
    raw_image,
    source_bytes,
    stored_bytes,
)
from ncdc_spec.registers.register_map import CTRL_COMMIT, CTRL_START

__all__ = ["bench_files", "pattern"]

_FILL = 0xA5            # bytes of the picture's area that are not written
_COUNT = 5              # bits of the number of words of a burst


def pattern(geometry, seed=1):
    """A raw frame of noise over a ramp: every window differs from its neighbours."""
    width, height = geometry.distorted
    noise = np.random.default_rng(seed).integers(0, 128, (height, width))
    ramp = (np.arange(width) + np.arange(height)[:, None]) % 128
    return (noise + ramp).astype(np.uint8)


def bench_files(corrector, verilog, module, raw):
    """Text of the test bench of ``module`` and of the files it reads, by file name.

    Parameters
    ----------
    corrector : ncdc_hdl.corrector.Corrector
    verilog, module : str
        Verilog generated from it, with Avalon's or AXI's ports, and its module.
    raw : ndarray of uint8, shape (distorted height, distorted width)
    """
    return _Bench(corrector, verilog, module).files(raw)


class _Bench:
    """Text of a test bench."""

    def __init__(self, corrector, verilog, module):
        self.corrector, self.module, self.name = corrector, module, f"{module}_tb"
        self.hardware, self.descriptor = corrector.hardware, corrector.descriptor
        self.geometry = self.descriptor.geometry
        self.addresses = FrameAddresses.after_reset(self.geometry, self.hardware.data_width)
        self.word = self.hardware.data_width // 8
        self.ports = {port.name: port for port in ports_of_text(verilog, module)}
        self.connections, self.wires, self.models = [], [], []

    def files(self, raw):
        """All files, by name."""
        axi = self.hardware.axi
        raw_words = self._hex(np.frombuffer(raw_image(raw, self.addresses.pitch), np.uint8),
                              source_bytes(self.geometry, self.addresses.pitch), 0, self.word)
        words, lanes = self._expected(raw)
        self._clock(axi)
        self._registers(axi)
        for k in range(self.corrector.fetch.ports):
            self._reader(f"read{k}", len(raw_words), k + 1, axi)
        if self.hardware.stream:
            self._sink(len(words), lanes, axi)
        else:
            self._writer(len(words), axi)
        for name in self.ports:
            if f".{name}(" not in "\n".join(self.connections):
                port = self.ports[name]
                self._connect(name, f"{port.width}'d0" if port.direction == "input" else "")
        return {f"{self.name}.v": self._text(len(words), axi),
                f"{self.name}_raw.hex": "\n".join([*raw_words, ""]),
                f"{self.name}_expected.hex": "\n".join([*words, ""])}

    def _hex(self, data, size, fill, word):
        """Words of ``word`` bytes, least significant byte first, of at least ``size`` bytes."""
        count = -(-max(size, len(data)) // word) * word
        padded = np.pad(data, (0, count - len(data)), constant_values=fill)
        return [row[::-1].tobytes().hex() for row in padded.reshape(-1, word)]

    def _expected(self, raw):
        """Words of the corrected picture in memory, or groups of pixels; groups per row."""
        picture = correct(self.descriptor, raw, strip=self.hardware.strip).picture
        if not self.hardware.stream:
            form = output_format(self.hardware.format)
            data = np.frombuffer(stored_bytes(picture, form).tobytes(), np.uint8)
            return self._hex(data, frame_bytes(self.geometry, form), _FILL, self.word), 0
        order = [1, 2, 0] if self.hardware.axi else [2, 1, 0]      # from the lowest byte on
        data = np.ascontiguousarray(picture[..., order]).reshape(-1)
        lanes = self.hardware.lanes
        return self._hex(data, 0, 0, 3 * lanes), self.geometry.corrected_width // lanes

    def _connect(self, port, value):
        self.connections.append(f"        .{port}({value})")

    def _wire(self, prefix, names):
        """Wires for these ports of the module, connected."""
        for name in names:
            port = self.ports[prefix + name]
            self.wires.append(f"    wire {port.range:>7} {port.name};")
            self._connect(port.name, port.name)

    def _clock(self, axi):
        if axi:
            pairs = (("aclk", "clk"), ("aresetn", "!rst"), ("core_rst", "1'b0"))
        else:
            pairs = (("clk", "clk"), ("rst", "rst"), ("memory_rst", "rst"))
        for port, value in (*pairs, ("irq", "irq")):
            self._connect(port, value)

    def _registers(self, axi):
        if not axi:
            for name in ("address", "write", "writedata", "waitrequest"):
                self._connect(f"csr_{name}", f"csr_{name}")
            self._connect("csr_read", "1'b0")
            return
        self._wire("s_axi_", ("awready", "wready", "bvalid"))
        for port, value in (("awaddr", "{csr_address, 2'b00}"), ("awvalid", "csr_write"),
                            ("wdata", "csr_writedata"), ("wvalid", "csr_write"),
                            ("wstrb", "4'hf"), ("bready", "1'b1"), ("arvalid", "1'b0"),
                            ("rready", "1'b1")):
            self._connect(f"s_axi_{port}", value)
        # Address and data are taken in the same clock. The next access begins after the answer.
        self.models.append(
            "    reg taken = 0;\n"
            "    always @(posedge clk) taken <= csr_write && (taken || s_axi_awready);\n"
            "    assign csr_waitrequest = !(taken && s_axi_bvalid);")

    def _reader(self, reader, words, seed, axi):
        prefix = f"m_axi_{reader}_" if axi else f"{reader}_"
        width = self.hardware.data_width
        if axi:
            self._wire(prefix, ("araddr", "arlen", "arvalid", "arready", "rdata", "rvalid",
                                "rlast"))
            self.wires.append(f"    wire {reader}_waitrequest;")
            self.models.append(f"    assign {prefix}arready = !{reader}_waitrequest;")
            joined = {"address": f"{prefix}araddr", "read": f"{prefix}arvalid",
                      "burstcount": f"{prefix}arlen[4:0] + 5'd1",
                      "waitrequest": f"{reader}_waitrequest", "readdata": f"{prefix}rdata",
                      "readdatavalid": f"{prefix}rvalid", "last": f"{prefix}rlast"}
            count = _COUNT
        else:
            names = ("address", "read", "burstcount", "waitrequest", "readdata", "readdatavalid")
            self._wire(prefix, names)
            joined = {name: prefix + name for name in names} | {"last": ""}
            count = self.ports[f"{prefix}burstcount"].width
        self.wires.append(f"    wire [31:0] {reader}_outside;")
        joined |= {"clk": "clk", "rst": "rst", "outside": f"{reader}_outside"}
        self.models.append(
            f"    ncdc_tb_reader #(.WIDTH(WIDTH), .WORDS({words}), .COUNT({count}), "
            f".SEED({seed})) {reader}_memory (\n        "
            + ", ".join(f".{name}({value})" for name, value in joined.items()) + ");")
        assert width == self.ports[f"{prefix}{'rdata' if axi else 'readdata'}"].width

    def _writer(self, words, axi):
        prefix = "m_axi_write_" if axi else "write_"
        if axi:
            self._wire(prefix, ("awaddr", "awlen", "awvalid", "awready", "wdata", "wstrb", "wlast",
                                "wvalid", "wready", "bvalid", "bready"))
            self.wires.append("    wire write_write, write_waitrequest;")
            names = ("awvalid", "awready", "wvalid", "wlast", "wready", "bvalid", "bready")
            self.models.append(
                "    ncdc_tb_axi_writer #(.WIDTH(WIDTH)) write_answers (\n"
                "        .clk(clk), .rst(rst), .write(write_write), "
                ".waitrequest(write_waitrequest),\n        "
                + ", ".join(f".{name}({prefix}{name})" for name in names) + ");")
            joined = {"address": f"{prefix}awaddr", "write": "write_write",
                      "burstcount": f"{prefix}awlen[4:0] + 5'd1", "writedata": f"{prefix}wdata",
                      "byteenable": f"{prefix}wstrb", "waitrequest": "write_waitrequest"}
            count = _COUNT
        else:
            names = ("address", "write", "burstcount", "writedata", "byteenable", "waitrequest")
            self._wire(prefix, names)
            joined = {name: prefix + name for name in names}
            count = self.ports["write_burstcount"].width
        self.wires.append("    wire [31:0] write_outside;")
        joined |= {"clk": "clk", "rst": "rst", "outside": "write_outside"}
        self.models.append(
            f"    ncdc_tb_writer #(.WIDTH(WIDTH), .WORDS({words}), .BASE({self.addresses.target}), "
            f".COUNT({count})) picture (\n        "
            + ", ".join(f".{name}({value})" for name, value in joined.items()) + ");")

    def _sink(self, words, row, axi):
        names = (("tvalid", "tready", "tdata", "tuser", "tlast") if axi else
                 ("valid", "ready", "data", "startofpacket", "endofpacket"))
        prefix = "m_axis_" if axi else "stream_"
        self._wire(prefix, names)
        joined = dict(zip(("valid", "ready", "data", "first", "last"),
                          (prefix + name for name in names)))
        joined |= {"clk": "clk", "rst": "rst"}
        self.models.append(
            f"    ncdc_tb_sink #(.WIDTH({24 * self.hardware.lanes}), .WORDS({words}), "
            f".ROW({row if axi else words})) picture (\n        "
            + ", ".join(f".{name}({value})" for name, value in joined.items()) + ");")

    def _text(self, words, axi):
        registers = {r.name: r.address for r in self.corrector.registers.table}
        address = self.ports["s_axi_awaddr"].width - 2 if axi else self.ports["csr_address"].width
        width, height = self.geometry.corrected
        outside = [f"read{k}_outside" for k in range(self.corrector.fetch.ports)]
        outside += [] if self.hardware.stream else ["write_outside"]
        values = {
            "NAME": self.name, "MODULE": self.module, "WIDTH": self.hardware.data_width,
            "LIMIT": 100_000 + 100 * width * height, "ADDRESS_HIGH": address - 1,
            "IRQ_ENABLE": registers["IRQ_ENABLE"], "CTRL": registers["CTRL"],
            "START": CTRL_COMMIT | CTRL_START, "CHECK": "picture", "COUNT": words,
            "WHAT": "groups" if self.hardware.stream else "words", "PIXELS": width * height,
            "OUTSIDE": "".join(f" || {name} != 0" for name in outside),
            "WIRES": "\n".join(self.wires), "PORTS": ",\n".join(self.connections),
            "MODELS": "\n".join(self.models)}
        output = ["sink.v"] if self.hardware.stream else ["writer.v", *(["axi.v"] if axi else [])]
        folder = files("ncdc_hdl.export.testbench")
        text = "".join((folder / name).read_text()
                       for name in ("top.v", "reader.v", *output))
        for name, value in values.items():
            text = text.replace("{{" + name + "}}", str(value))
        # Its modules have its name as a prefix, so that several benches can be compiled together.
        return re.sub(r"\bncdc_tb_", f"{self.name}_", text)
