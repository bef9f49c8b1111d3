"""Waveforms of a simulation, as a file for a viewer."""

import shutil
import subprocess
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from ncdc_sim.tools import SimulationError
from ncdc_spec.errors import InputError
from ncdc_spec.files import replace_file

__all__ = ["FORMATS", "Waves", "build_options", "recorded"]

FORMATS = ("vcd", "fst")

_FST_HEADERS = ("lz4.h", "zlib.h")


@dataclass(frozen=True)
class Waves:
    """File for every signal's changes.

    Parameters
    ----------
    path : Path
    kind : str
        One of :data:`FORMATS`. Value Change Dump is a text of IEEE 1364 that every viewer reads.
        The Fast Signal Trace of GTKWave and Surfer is packed.

    Raises
    ------
    InputError
        If the format is none of these.
    """
    path: Path
    kind: str = "vcd"

    def __post_init__(self):
        if self.kind not in FORMATS:
            raise InputError(f"the format of waveforms is {self.kind!r}, one of "
                             f"{', '.join(FORMATS)} is needed")


def build_options(waves, simulator):
    """Verilator's options of a build that can write ``waves``; it is slower even if it does not.

    Icarus Verilog needs none.

    Raises
    ------
    InputError
        If Verilator's writer of FST does not compile here.
    """
    if not waves or simulator != "verilator":
        return ()
    if waves.kind == "fst":
        _check_libraries()
    return (f"--trace-{waves.kind}",)


def _check_libraries():
    """Reject options that would fail in the middle of a build, with the compiler's message."""
    includes = "".join(f"#include <{header}>\n" for header in _FST_HEADERS)
    compiler = shutil.which("g++")
    if compiler and subprocess.run([compiler, "-E", "-x", "c++", "-"], input=includes.encode(),
                                   capture_output=True).returncode:
        raise InputError(
            f"Verilator packs FST with {' and '.join(_FST_HEADERS)}, which are not installed here "
            "(apt install liblz4-dev zlib1g-dev); VCD, or the simulator icarus, goes without")


@contextmanager
def recorded(waves, simulator):
    """Yield the arguments of a run that make it write ``waves``; its file is there at the end.

    A run that fails leaves its waveforms: they are what one looks at then.
    """
    if waves is None:
        yield ()
        return
    failure = None
    with replace_file(waves.path) as temporary:
        try:
            icarus = ("-fst",) if simulator == "icarus" and waves.kind == "fst" else ()
            yield (*icarus, f"+waves={temporary}")
        except SimulationError as error:
            if not temporary.stat().st_size:
                raise
            failure = error
    if failure:
        raise failure
