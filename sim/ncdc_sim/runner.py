"""Compiling Verilog with Verilator or Icarus, once, and running it with its output watched."""

import os
import re
import shutil
import subprocess
import tempfile
from collections import deque
from pathlib import Path

from ncdc_sim.tools import (
    WAIVERS,
    SimulationError,
    call,
    check_compiler,
    environment,
    tool,
    version,
)
from ncdc_spec.builds import built, key_of, without_header

__all__ = ["HDL", "build", "build_bench", "command_of", "hdl_text", "run",
           "results_of"]

HDL = Path(__file__).parent / "hdl"

# Macros of Verilator's Makefile while it has none of the options that follow.
_HEADER_MACROS = ("-DVERILATOR=1", *(f"-DVM_{name}=0" for name in (
    "COVERAGE", "SC", "TIMING", "TRACE", "TRACE_FST", "TRACE_VCD", "TRACE_SAIF")))
_OTHER_HEADER = ("--coverage", "--main", "--timing", "--trace", "-CFLAGS")


def hdl_text(name):
    """Text of the file ``name`` of :data:`HDL`, with the files that it includes filled in."""
    return re.sub(r'^`include "(.*)"\n', lambda found: hdl_text(found[1]),
                  (HDL / name).read_text(), flags=re.MULTILINE)


def build(name, top, sources, *, defines=None, simulator="verilator", main=None, options=(),
          optimise=None):
    """Program that simulates module ``top``, compiled if it was not yet; see :func:`command_of`.

    Parameters
    ----------
    name : str
        Start of the name of the build's folder.
    top : str
        Top module. Under Verilator its clock comes from ``main``.
    sources : list of (file name, Verilog text)
        Compiled in this order.
    defines : dict
        Verilog macros and their values.
    simulator : str
        One of ``ncdc_sim.tools.SIMULATORS``.
    main : Path
        C++ main program (Verilator only).
    options : sequence of str
        More options for Verilator.
    optimise : str or None
        Option of the C++ compiler (Verilator only). None: that of ``NCDC_OPTIMISE``, else -O2.
        With -O0 it compiles in a third of the time and simulates at a third of the speed, which
        suits runs of less than some hundred thousand clocks.

    Raises
    ------
    InputError
        If the simulator is unknown, or it or what it compiles with is not installed.
    SimulationError
        If the sources do not compile.
    """
    compiler = tool(simulator)
    optimise = optimise or os.environ.get("NCDC_OPTIMISE", "-O2")
    defines = [f"-D{key}" if value is None else f"-D{key}={value}"
               for key, value in sorted((defines or {}).items())]
    if simulator == "icarus":
        program = f"{top}.vvp"
        command = [compiler, "-g2012", "-s", top, "-o", program, *defines]
    else:
        program = top
        command = [compiler, "--cc", "--exe", "--build", "-j", "2", "-O3", "--top-module", top,
                   "--timescale", "1ns/1ps", "--Mdir", "model", "-o", f"../{program}",
                   *_make_flags(optimise, main, options),
                   *WAIVERS, *options, *_coverage(), *defines]
    texts = [(file, without_header(text)) for file, text in sources]
    if main is not None and simulator == "verilator":
        texts.append((main.name, main.read_text()))

    def compile_in(folder):
        check_compiler(simulator)
        for file, text in texts:
            (folder / file).write_text(text)
        header = _header(optimise, command) if simulator == "verilator" else ()
        call([*command, *header, *(file for file, _ in texts)], folder)
        for file, _ in texts:
            (folder / file).unlink()
        shutil.rmtree(folder / "model", ignore_errors=True)

    key = key_of(name, simulator, version(simulator), *command[1:], *sum(texts, ()))
    return built(key, compile_in) / program


def build_bench(name, top, sources, *, simulator="verilator", defines=None, options=(), **more):
    """:func:`build` of a bench whose clocks are inputs; ``hdl/bench_main.cpp`` has their names.

    Under Icarus ``hdl/bench_clocks.v`` drives them.
    """
    if simulator == "icarus":
        sources = [("bench_clocks.v", hdl_text("bench_clocks.v")), *sources]
        defines = {**(defines or {}), "NCDC_BENCH": top}
        return build(name, "bench_clocks", sources, simulator=simulator, defines=defines, **more)
    return build(name, top, sources, simulator=simulator, defines=defines,
                 main=HDL / "bench_main.cpp", options=("--prefix", "Vbench", *options), **more)


def _coverage():
    """Verilator's options for counting what a run reaches, into the file ``NCDC_COVERAGE``."""
    return ["--coverage-line", "--coverage-toggle"] if os.environ.get("NCDC_COVERAGE") else []


def _make_flags(optimise, main, options):
    """Verilator's options for compiling its C++.

    Without optimisation headers take most of the time, once per file and twice for the precompiled
    header: a single file is faster. It includes the main program, unless Verilator writes
    supporting files of its own, as it does for waveforms.
    """
    flags = [f"OPT_FAST={optimise}"]
    if optimise == "-O0":
        flags.append("VM_PARALLEL_BUILDS=0")
        if main is not None and not any(option.startswith("--trace") for option in options):
            flags += ["VM_USER_CLASSES=", f"VM_SUPPORT_FAST={main.stem}"]
    return [text for flag in flags for text in ("-MAKEFLAGS", flag)]


def _header(optimise, command):
    """Options of ``command`` that let the C++ compiler read Verilator's header precompiled.

    The header takes a third of the time of a build with -O0. Where the compiler finds that the
    precompiled one does not fit, it reads the text. None for other builds: those of several files
    precompile a header of their own, and other options of Verilator change what it declares.
    """
    root = environment().get("VERILATOR_ROOT")
    other = any(option.startswith(_OTHER_HEADER) for option in command)
    if optimise != "-O0" or other or root is None:
        return ()
    include = ("-O0", f"-I{root}/include", f"-I{root}/include/vltstd", *_HEADER_MACROS)

    def precompile(folder):
        (folder / "model.h").write_text('#include "verilated.h"\n')
        call(["g++", *include, "-x", "c++-header", "model.h"], folder)

    header = built(key_of("header", version("verilator"), *include), precompile) / "model.h"
    # After the option of the same name in `command`: make takes the last.
    return "-MAKEFLAGS", f"OPT_FAST='-O0 -include {header}'"


def command_of(program):
    """Command line, without arguments, that runs what :func:`build` made."""
    return ["vvp", "-N", str(program)] if program.suffix == ".vvp" else [str(program)]


def run(command, folder, on_line=lambda line: None):
    """Run a built simulation in ``folder``, handing each line it prints to ``on_line``.

    Raises
    ------
    SimulationError
        If it ends with an error status; the message holds the last lines it printed.
    """
    last = deque(maxlen=20)
    with subprocess.Popen(command, cwd=folder, env=environment(), text=True, errors="replace",
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        try:
            for line in process.stdout:
                last.append(line.rstrip())
                on_line(last[-1])
        except BaseException:       # Ctrl-C too must not leave the simulation running
            process.kill()
            raise
    if process.returncode:
        raise SimulationError(f"the simulation ended with status {process.returncode}:\n"
                              + "\n".join(last))


def results_of(program, plusargs, hear=lambda kind, *values: None, more=()):
    """Run what :func:`build` made in a folder of its own; the numbers of its lines ``RESULT name
    number``, by name.

    Parameters
    ----------
    program : Path
    plusargs : dict
    hear : callable
        Called with the words of every other line that has any.
    more : sequence of str
        Further plusargs.

    Raises
    ------
    SimulationError
        If it ends with an error status, or without a result.
    """
    results = {}

    def on_line(line):
        kind, *values = line.split() or ["RESULT"]
        if kind != "RESULT":
            hear(kind, *values)
        elif values:
            results[values[0]] = int(values[1])

    with tempfile.TemporaryDirectory(prefix="ncdc-") as folder:
        run([*command_of(program), *(f"+{name}={value}" for name, value in plusargs.items()),
             *more], folder, on_line)
    if not results:
        raise SimulationError("the simulation ended without a result")
    return results
