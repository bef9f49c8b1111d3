"""Generated Verilog of one free-running pipeline, run on every value of its input."""

import tempfile
from pathlib import Path

import numpy as np

from ncdc_hdl.export.verilog import module_verilog
from ncdc_sim.runner import build, command_of, run
from ncdc_spec.errors import InputError

__all__ = ["every_value", "pipeline_outputs", "scattered"]

TOP = "pipeline"
_WORD = 32          # bits of a value in the files that the simulation reads and writes


def every_value(q):
    """All raw values of the format ``q``, ascending, as int32."""
    return np.arange(q.lo, q.hi + 1, dtype=np.int32)


def scattered(count):
    """A permutation of 0 .. ``count`` - 1 (a power of two) whose neighbours are far apart.

    Ascending inputs would hide a stage that is one clock out of step: neighbours differ too
    little. Multiplying by an odd constant changes high and low bits at every step.
    """
    if count & (count - 1) or count <= 0:
        raise ValueError(f"count is {count}, a power of two is needed")
    return np.arange(count, dtype=np.int64) * 0x9E3779B1 & (count - 1)


def pipeline_outputs(component, inputs, *, progress=None):
    """Outputs of a component's Verilog for ``inputs``, one per clock, in a Verilator model.

    Parameters
    ----------
    component : amaranth.lib.wiring.Component
        Members ``i`` and ``o`` (signed, at most 32 bits), attribute ``latency``; free-running.
    inputs : array_like of int
        Raw values of ``i``, in the order of their clocks.
    progress : callable
        Called with "building" and "running".

    Returns
    -------
    ndarray of int32
        Raw ``o`` for each input: the value that leaves the pipeline ``latency`` clocks after it.

    Raises
    ------
    InputError
        If Verilator is not installed, or an input does not fit the port.
    SimulationError
        If the Verilog does not compile or the run fails.
    """
    progress = progress or (lambda step: None)
    bits_in, bits_out = component.i.shape().width, component.o.shape().width
    inputs = np.asarray(inputs)
    if max(bits_in, bits_out) > _WORD:
        raise InputError(f"ports have {bits_in} and {bits_out} bits, the limit is {_WORD}")
    limit = 1 << (bits_in - 1)
    if inputs.size and not (-limit <= inputs.min() and inputs.max() < limit):
        raise InputError(f"inputs from {inputs.min()} to {inputs.max()} do not fit {bits_in} bits")
    progress("building")
    program = build(TOP, TOP, [(f"{TOP}.v", module_verilog(component, TOP))],
                    main=Path(__file__).parent / "pipeline_main.cpp")
    progress("running")
    with tempfile.TemporaryDirectory(prefix="ncdc-") as name:
        folder = Path(name)
        (inputs.astype(np.int64) & ((1 << bits_in) - 1)).astype("<u4").tofile(folder / "inputs")
        run([*command_of(program), "inputs", "outputs", str(component.latency)], folder)
        raw = np.fromfile(folder / "outputs", "<u4")
    sign = 1 << (bits_out - 1)
    return ((raw.astype(np.int64) ^ sign) - sign).astype(np.int32)
