"""Runs SymbiYosys on a wrapper around the design."""

import os
import re
import subprocess
import sys
from pathlib import Path
from unittest import mock

from amaranth.back import rtlil

from formal.properties import Property

__all__ = ["FAIL", "PASS", "run"]

PASS, FAIL = "PASS", "FAIL"
# Clock after clock from the first, Yices takes a seventh of z3's time for the longest; an induction
# over queues that z3 closes in forty seconds it does not close in four minutes.
_SOLVERS = {"prove": "z3", "bmc": "yices", "cover": "yices"}

_TOOLS = Path(sys.executable).parent     # of the virtual environment


def run(top, folder, *, mode, depth, only=None):
    """Result of one task: (status, names of the properties that failed, or were reached).

    Parameters
    ----------
    top : wiring.Component
        Its inputs are free in each clock, the reset as well. They must be made in ``__init__``:
        an input made in ``elaborate`` may be left unconnected, and all holds in vain.
    folder : Path
        New files go there.
    mode : str
        ``prove`` (k-induction of ``depth``, which proves for all time), ``bmc`` (the first
        ``depth`` clocks) or ``cover`` (all covers reached in ``depth`` clocks).
    depth : int
    only : str or None
        The name of the one assertion to make.
    """
    with mock.patch.object(Property, "only", only):
        netlist = rtlil.convert(top, name="top")
    task = (f"[options]\nmode {mode}\ndepth {depth}\n\n"
            f"[engines]\nsmtbmc --syn --nomem {_SOLVERS[mode]}\n\n"
            "[script]\nread_rtlil top.il\nprep -flatten -top top\n\n[files]\ntop.il\n")
    (folder / "top.il").write_text(netlist)
    (folder / "task.sby").write_text(task)
    result = subprocess.run(
        [_TOOLS / "yowasp-sby", *(f"--{name}={_TOOLS / f'yowasp-{tool}'}" for name, tool in
         (("yosys", "yosys"), ("smtbmc", "yosys-smtbmc"), ("witness", "yosys-witness"))),
         "-f", "-d", "task", "task.sby"], cwd=folder, capture_output=True, text=True,
        env=os.environ | {"PATH": f"{_TOOLS}{os.pathsep}{os.environ.get('PATH', os.defpath)}"})
    found = re.search(r"DONE \((\w+), rc=\d+\)", result.stdout)
    if not found:
        raise RuntimeError(f"sby gave no result: {result.stdout}{result.stderr}")
    names = re.findall(r"summary: .*check_flatten_(\w+?)__\d+ at", result.stdout)
    # A part that is called like a signal has a number after its name.
    return found[1], {re.sub(r"_\d+$", "", name.replace("__", ".")) for name in names}
