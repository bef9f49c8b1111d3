"""The designs of the tan-sigmoid: results and errors of all inputs, and their gateware."""

import numpy as np
import pytest

from ncdc_hdl.neural.tansig import Tansig
from ncdc_spec.tansig import FRACTION_BITS, VARIANTS, tansig
from pipelines import run_pipeline

__all__ = ["NAMES", "edges", "every_design", "errors", "every_magnitude", "gateware", "stimuli"]

# Variants and fraction bits of all designs, which take seconds to make.
NAMES = [(variant, bits) for variant in VARIANTS for bits in FRACTION_BITS]


def every_design(names=NAMES):
    """Mark of tests that take a ``design``: its fixture makes that of its parameter."""
    return pytest.mark.parametrize("design", names, ids=lambda name: "%s%d" % name, indirect=True)


def every_magnitude(design):
    """Raw results of all magnitudes."""
    return tansig(np.arange(design.input.hi + 1), design)


def errors(q, design):
    """Errors in units of 2**-P of the raw results ``q`` of all magnitudes.

    tanh in double precision is wrong by 2**-31 of a unit at most: it cannot decide a comparison
    at the second decimal.
    """
    n = np.arange(design.input.hi + 1)
    return (design.output.real(q) - np.tanh(design.input.real(n) / 2)) * 2.0**design.fraction_bits


def edges(design):
    """Inputs around every boundary of a thirty-second, around zero and at both ends."""
    q = design.input
    regions = np.arange(0, q.hi, 1 << (q.f_bits - 5))
    near = (regions[:, None] + np.arange(-2, 3)).ravel()
    return np.unique(np.clip(np.concatenate([near, -near, [q.lo, q.lo + 1, q.hi]]), q.lo, q.hi))


def gateware(design, n):
    """Results of the gateware."""
    dut = Tansig(design)
    return np.ravel(run_pipeline(dut, n.tolist(), lambda ctx, x: ctx.set(dut.i, x),
                                 lambda: [dut.o]))


def stimuli(design, count):
    """Inputs: both ends, around zero, around region boundaries, random, random where f rises."""
    rng, q = np.random.default_rng(7), design.input
    return np.concatenate([rng.choice(edges(design), count), edges(design)[:3], edges(design)[-3:],
                           [0, 1, -1], rng.integers(q.lo, q.hi, count),
                           rng.integers(-2 << q.f_bits, 2 << q.f_bits, count)])
