"""Neurons, over the edges of rounding and saturation; each item has weights and a bias of its own.
"""

import numpy as np

from ncdc_model.golden.network import hidden_neuron, output_neuron
from pipelines import run_bench

__all__ = ["check_hidden_neuron", "check_output_neuron"]

_COUNT = 400


def _items(q, terms, rng):
    """(inputs, weights, bias) of sums that lie on a rounding's edge, or next to it: there the
    lowest bit of any term decides. All formats' limits are among them."""
    for k in range(_COUNT):
        x, w, bias = (rng.integers(each.lo, each.hi, count, endpoint=True) >> int(rng.integers(4))
                      for each, count in ((q.xq, terms), (q.wq, terms), (q.bq, 1)))
        if k % 4 == 0:
            x, w, bias = (rng.choice([each.lo, each.hi, 0], count)
                          for each, count in ((q.xq, terms), (q.wq, terms), (q.bq, 1)))
        if k % 2:
            # The last term fills up the dropped bits to a half, or to the step before.
            x[-1], w[-1] = 1, 0
            total = int(x @ w) + (int(bias[0]) << q.bias_shift)
            modulus = 1 << q.shift
            rest = ((modulus >> 1) - total - int(rng.integers(2))) % modulus
            w[-1] = rest - modulus if rest > q.wq.hi else rest
        yield x.tolist(), w.tolist(), int(bias[0])


def _run(dut, items):
    """Results of ``items`` back to back, each of as many clocks as the neuron has turns."""
    turns, n, got = dut.turns, dut.terms, []
    first = [item for item in items for _ in range(turns)]

    def of(clock, late):
        """(item, turn) of what an input gets ``late`` clocks after the activations."""
        at = clock - late
        return (first[at], at % turns) if 0 <= at < len(first) else (items[-1], 0)

    async def bench(ctx):
        for clock in range(len(first) + dut.latency):
            item, turn = of(clock, 0)
            ctx.set(dut.i, item[0][turn * n:][:n])
            if turns > 1:
                ctx.set(dut.first, turn == 0)
            item, turn = of(clock, dut.weights_clock)
            ctx.set(dut.weights, item[1][turn * n:][:n])
            ctx.set(dut.bias, of(clock, dut.bias_clock)[0][2])
            await ctx.tick()
            at = clock + 1 - dut.latency
            if at >= 0 and at % turns == 0 and len(got) < len(items):
                got.append(ctx.get(dut.o))

    run_bench(dut, bench)
    return got


def _check(dut, model, seed):
    items = list(_items(dut.format, dut.terms * dut.turns, np.random.default_rng(seed)))
    expected = [int(model(*item)) for item in items]
    np.testing.assert_array_equal(_run(dut, items), expected)
    assert {dut.format.yq.lo, dut.format.yq.hi} <= set(expected) and len(set(expected)) > 100


def check_hidden_neuron(dut, formats):
    """A :class:`ncdc_hdl.neural.neuron.HiddenNeuron` compared with the golden model."""
    _check(dut, lambda x, w, b: hidden_neuron(*x, w, b, formats), 1)


def check_output_neuron(dut, formats):
    """A :class:`ncdc_hdl.neural.neuron.OutputNeuron` compared with the golden model."""
    _check(dut, lambda x, w, b: output_neuron([np.int64(one) for one in x], w, b, formats), 2)
