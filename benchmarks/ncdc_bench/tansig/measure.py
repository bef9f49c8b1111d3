"""The tan-sigmoid's Verilog on every input: error, equality, size, clock."""

import numpy as np

from ncdc.toolchain.flows import Registered, cyclone_v, synthesise
from ncdc_bench.tansig.accuracy import measure
from ncdc_bench.tansig.exhaustive import every_value, pipeline_outputs, scattered
from ncdc_hdl.export.verilog import module_verilog
from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.tansig import tansig

__all__ = ["sampled_inputs", "tansig_row", "verilog_outputs"]

SAMPLES = 1 << 16


def sampled_inputs(q, count=SAMPLES):
    """About ``count`` raw values of format ``q``, ascending, in pairs of n and -n.

    Both ends, zero, the values around every multiple of 1/32 (where tables have their steps), and
    random ones; the same at every call.
    """
    rng = np.random.default_rng(20)
    steps = np.arange(0, q.hi, max(1, 1 << max(q.f_bits - 5, 0)))
    near = (steps[:, None] + np.arange(-2, 3)).ravel()
    random = rng.integers(0, q.hi, count // 2, endpoint=True)
    some = np.concatenate([near, random[:max(0, count // 2 - near.size)], [q.hi]])
    some = np.clip(np.concatenate([some, -some, [q.lo]]), q.lo, q.hi)
    return np.unique(some).astype(np.int32)


def verilog_outputs(component, n, *, progress=None):
    """Raw results of the generated Verilog of ``component``, a Tansig, for inputs ``n``.

    The inputs enter in an order in which neighbours are far apart. Errors raised: as
    :func:`ncdc_bench.tansig.exhaustive.pipeline_outputs`.
    """
    order = scattered(1 << int(n.size - 1).bit_length())
    order = order[order < n.size]
    result = np.empty(n.size, np.int32)
    result[order] = pipeline_outputs(component, n[order], progress=progress)
    return result


def tansig_row(design, *, sampled=False, synthesis=True, routed=True,
               progress=lambda step: None):
    """Figures of one design, measured on its generated Verilog.

    Parameters
    ----------
    design : ncdc_spec.tansig.Design
    sampled : bool
        Run :func:`sampled_inputs` instead of every input.
    synthesis : bool
        Add those of :func:`ncdc.toolchain.flows.synthesise`; the input is registered.
    routed : bool
        Of these, the ones on ECP5 too; without, no placement runs.
    progress : callable
        Called with the name of each step.

    Returns
    -------
    dict
        ``max_ulp``, ``bound_ulp``: in units of 2**-``fraction_bits``. ``correctly_rounded``: share
        of results within half of that. ``mse``: of the real values; ``mse_ideal``: of ideal
        rounding. ``differences``: results that are not the golden model's. ``latency``: in clocks.
        The booleans of :class:`ncdc_bench.tansig.accuracy.Accuracy`.

    Raises
    ------
    InputError
        If a tool is not installed.
    SimulationError, SynthesisError
        If one fails.
    """
    n = sampled_inputs(design.input) if sampled else every_value(design.input)
    component = Tansig(design)
    raw = verilog_outputs(component, n, progress=progress)
    progress("golden model")
    golden = tansig(n, design)
    progress("exact reference")
    accuracy = measure(n, raw, design)
    row = {
        "variant": design.variant, "fraction_bits": design.fraction_bits,
        "input": str(design.input), "inputs": accuracy.inputs, "exhaustive": not sampled,
        "max_ulp": accuracy.max_ulp, "bound_ulp": design.bound_ulp,
        "worst_input": accuracy.worst_input, "correctly_rounded": accuracy.correctly_rounded,
        "mse": accuracy.mse, "mse_ideal": 4.0**-design.fraction_bits / 12,
        "differences": int((raw != golden).sum()), "odd": accuracy.odd, "zero": accuracy.zero,
        "monotonic": accuracy.monotonic, "saturated": accuracy.saturated,
        "latency": component.latency, "stages": design.stages, "adders": design.adders,
        "table_bits": design.table_bits, "multipliers": design.multipliers}
    if synthesis:
        verilog = module_verilog(Registered(Tansig(design)), "tansig")
        row |= (synthesise if routed else cyclone_v)(verilog, "tansig", progress=progress)
    progress("done")
    return row
