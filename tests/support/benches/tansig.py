"""Tan-sigmoid, clock by clock, compared with ``ncdc_spec.tansig.tansig``."""

import cocotb
import numpy as np

from benches.common import pipeline, settings, signed, start
from ncdc_spec.tansig import TansigDesign, tansig

__all__ = ["equals_model"]


def inputs(design, count=3000):
    """Corners, both sides of every region's edges, then random."""
    q, step = design.input, 1 << design.fine_bits
    edges = np.arange(q.lo, q.hi, step * 16)
    corners = np.concatenate([[0, 1, -1, q.lo, q.lo + 1, q.hi, q.hi - 1], edges, edges + step - 1])
    return np.concatenate([corners, np.random.default_rng(1).integers(q.lo, q.hi, count)])


@cocotb.test()
async def equals_model(dut):
    """Every result, exactly ``latency`` clocks after its input."""
    design = TansigDesign()
    n = inputs(design)
    await start(dut, i=0)
    out = await pipeline(dut, {"i": n}, ["o"], settings()["latency"])
    got = [signed(value, design.output.width) for value in out["o"]]
    np.testing.assert_array_equal(got, tansig(n, design))
