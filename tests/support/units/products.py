"""A product, over the limits of both factors and of their parts."""

import numpy as np

from pipelines import run_pipeline

__all__ = ["check_product"]


def _corners(width):
    """Limits, and all values whose parts are at a limit, -1, 0 or 1 of theirs."""
    lo, hi = -(1 << (width - 1)), (1 << (width - 1)) - 1
    near = [sign * (1 << bit) + d for bit in (0, 16, 17, 18, width - 2) for sign in (-1, 1)
            for d in (-1, 0, 1)]
    return sorted({lo, lo + 1, hi, hi - 1, *(v for v in near if lo <= v <= hi)})


def check_product(dut):
    """Corners with corners, and 500 random pairs, one per clock."""
    widths = len(dut.a), len(dut.b)
    rng = np.random.default_rng(widths[0] * widths[1])
    items = [(a, b) for a in _corners(widths[0]) for b in _corners(widths[1])]
    items += zip(*(rng.integers(-1 << (width - 1), 1 << (width - 1), 500).tolist()
                   for width in widths))
    assert {(a < 0, b < 0) for a, b in items} == {(s, t) for s in (0, 1) for t in (0, 1)}

    def drive(ctx, item):
        ctx.set(dut.a, item[0])
        ctx.set(dut.b, item[1])

    got = [o for o, in run_pipeline(dut, items, drive, lambda: [dut.o])]
    assert got == [a * b for a, b in items]
