"""Upper bound of the error of the ``mmhbc`` tan-sigmoid, from its parameters."""

import numpy as np

from ncdc_spec.tansig.lvc import largest_rounding, quotient_error, round_shift

__all__ = ["error_bound", "error_terms"]

_KNOWN = 9         # rotations computed exactly; the others are bounded
_SLACK = 1e-6      # units of 2**-W: covers the double precision of this computation


def error_bound(design):
    """Bound of \\|f - result\\| in units of 2**-P, over every input of ``design``."""
    return float(error_terms(design)["total"].max())


def error_terms(design, known=_KNOWN):
    """Terms of the bound, in units of 2**-P, as arrays over (regions, known directions).

    Returns a dict of ``digit`` (the odd last bit), ``known`` (error of the table entry and of the
    rotations that are computed exactly), ``rotations`` (roundings of the others), ``angle``
    (their atanh(2**-s) minus 2**-s), ``quotient`` (roundings of the divisor's shifts),
    ``total``, and ``a``, the input in the middle of each part.

    All directions of the first rotations are computed with the integers themselves. So u is known,
    and its distance from the value v of an exact continuation. The roundings of the remaining
    rotations are bounded over the interval that they can reach. The effect of an error of e on f
    is exact: f(e) - f(u) = 2 (u - e) / ((1 + e) (1 + u)). With ``known`` = 0 only the table's
    entry is known, and each source of error has its own term.
    """
    w, unit = design.width, 2.0**design.fraction_bits
    known = min(known, len(design.shifts))
    done, rest = design.shifts[:known], design.shifts[known:]
    pattern = np.arange(1 << known)
    u = np.repeat(np.array(design.table), len(pattern)).reshape(-1, len(pattern))
    for k, shift in enumerate(done):
        step = round_shift(u, shift)
        u = u + np.where((pattern >> (known - 1 - k)) & 1, -step, step)
    powers = np.array([2.0**-s for s in rest])
    regions = np.arange(len(design.table))[:, None]
    a = (regions + pattern * 2.0**-known) * 2.0**-design.region_bits + powers.sum()
    v = np.exp(-a) / np.prod(np.sqrt(1 - powers**2)) * 2.0**w
    grow, shrink = np.prod(1 + powers), np.prod(1 - powers)

    lo, hi = u.astype(np.float64), u.astype(np.float64)
    roundings = np.full(u.shape, _SLACK)
    for s in rest:
        roundings = roundings + grow * largest_rounding(lo * 2.0**-s, hi * 2.0**-s)
        lo, hi = lo - hi * 2.0**-s - .5, hi + hi * 2.0**-s + .5
    slope = 2 / ((1 + v * shrink / 2.0**w) * (1 + np.maximum(lo, 0) / 2.0**w)) * unit / 2.0**w
    terms = {
        "digit": np.full(u.shape, .5),
        "known": slope * np.abs(u - v) * grow,
        "rotations": slope * roundings,
        "angle": slope * v * grow * np.expm1((np.arctanh(powers) - powers).sum()),
        "quotient": quotient_error(lo, hi, w, design.digits) * unit / 2.0**w,
    }
    return {**terms, "total": sum(terms.values()), "a": a}
