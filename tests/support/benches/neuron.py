"""Neurons, clock by clock: ``hidden_neuron`` and ``output_neuron`` of the golden model."""

import cocotb
import numpy as np

from benches.common import pipeline, settings, signed, start
from ncdc_model.golden.network import hidden_neuron, output_neuron
from ncdc_spec.descriptor import Formats

__all__ = ["equals_model"]


def joined(values, width):
    """Bits of an array of ``width``-bit numbers, the first one lowest."""
    return sum((int(v) & ((1 << width) - 1)) << (width * k) for k, v in enumerate(values))


def cases(rng, inputs, xq, wq, bq, yq):
    """(inputs, weights, bias): rounding and saturation edges, extremes, then random."""
    shift = bq.f_bits - yq.f_bits
    edges = [(e << shift) - (1 << (shift - 1)) + d for e in (yq.lo, yq.hi + 1, 0, 1)
             for d in (-1, 0, 1)]
    items = [([0] * inputs, [0] * inputs, b) for b in edges if bq.holds(b)]
    items += [([x] * inputs, [w] * inputs, b)
              for x in (xq.lo, xq.hi) for w in (wq.lo, wq.hi) for b in (bq.lo, bq.hi)]
    for scale in (1, 16, 256):
        items += [(rng.integers(xq.lo, xq.hi, inputs), rng.integers(wq.lo, wq.hi, inputs) // scale,
                   int(rng.integers(bq.lo, bq.hi)) // scale) for _ in range(20)]
    return items


@cocotb.test()
async def equals_model(dut):
    """Edges with changing weights, then one sample per clock with steady ones."""
    s, f, rng = settings(), Formats(), np.random.default_rng(1)
    if s["kind"] == "hidden":
        q = f.input, f.hidden_weight, f.hidden_bias, f.net

        def model(x, w, b):
            return hidden_neuron(x[0], x[1], w, b, f)
    else:
        q = f.tansig, f.output_weight, f.output_bias, f.coordinate

        def model(x, w, b):
            return output_neuron(x, w, b, f)
    xq, wq, bq, yq = q
    items = cases(rng, s["inputs"], *q)
    steady = rng.integers(wq.lo, wq.hi, s["inputs"]) // 64, int(rng.integers(bq.lo, bq.hi)) // 64
    stream = [(rng.integers(xq.lo, xq.hi, s["inputs"]), *steady) for _ in range(500)]
    # Weights may change between frames only: an item with its own has the pipeline for itself.
    fed = [item for item in items for _ in range(s["latency"])] + stream
    await start(dut, i=0, weights=0, bias=0)
    out = await pipeline(dut, {"i": [joined(x, xq.width) for x, _, _ in fed],
                               "weights": [joined(w, wq.width) for _, w, _ in fed],
                               "bias": [b for _, _, b in fed]}, ["o"], s["latency"])
    got = np.array([signed(value, yq.width) for value in out["o"]])
    expected = np.array([int(model([np.int64(v) for v in x], w, b)) for x, w, b in fed])
    own = len(items) * s["latency"]
    np.testing.assert_array_equal(got[:own:s["latency"]], expected[:own:s["latency"]])
    # The first of the steady ones still meet the weights before them.
    np.testing.assert_array_equal(got[own + s["latency"]:], expected[own + s["latency"]:])
    assert {yq.lo, yq.hi} <= set(expected.tolist())
