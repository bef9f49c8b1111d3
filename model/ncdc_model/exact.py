"""Linear algebra whose results depend neither on the order of summation nor on the library.

Levenberg-Marquardt from many starts amplifies the last bit of a sum into another network. The order
of summation in a BLAS depends on its threads and on the processor, so that one seed would give
another network on another machine. Here a matrix product is exact: its factors are cut to multiples
of a coarse unit, so that every partial sum fits in the 53 bits of a double. Several such products
give the precision (the error-free transformation of Ozaki, Ogita, Oishi and Rump, 2012). So the
library may add in any order. All other operations are elementwise, which IEEE 754 defines exactly.
``compiled/search.c`` does the same in C.
"""

from decimal import Decimal, localcontext
from functools import cache

import numpy as np

__all__ = ["TANH_STEPS", "cut", "eliminate", "least_squares", "products", "scale_of", "slices",
           "solve", "tanh", "tanh_table", "total", "triangular"]

TANH_STEPS = 32        # entries of the table of tanh for a change of its argument by 1

_BITS = 21             # fraction bits of a number cut at scale 1, whose limit is 1.4
_BLOCK = 1024          # terms of one exact sum: 1024 * (1.4 * 2**21)**2 < 2**53
_TINY = 1e-14          # of the diagonal: a smaller pivot is a rounding error
_TANH_END = 20         # from here on tanh is 1 in double precision


def scale_of(values, axis=None):
    """Smallest powers of two with max |values| <= 1.4 * scale; ``axis`` gets the length 1."""
    mantissa, exponent = np.frexp(np.abs(values).max(axis=axis, keepdims=True))
    return np.ldexp(1.0, exponent - (mantissa <= .7))


def cut(values, scale=1.0, out=None):
    """``values`` rounded to multiples of ``scale`` * 2**-21, where |values| <= 1.4 * ``scale``.

    ``scale`` holds powers of two and broadcasts to ``values``; ``out`` may be ``values``.
    """
    # Doubles near 1.5 * 2**31 are 2**-21 apart: the sum is rounded to a multiple of that.
    large = 1.5 * 2.0**(52 - _BITS) * scale
    out = np.add(values, large, out=out)
    return np.subtract(out, large, out=out)


def slices(values, scale, count):
    """List of ``count`` cut arrays, coarse to fine; their sum is ``values`` to 22 bits each."""
    parts = [cut(values, scale)]
    for _ in range(count - 1):
        values = values - parts[-1]
        scale = scale * 2.0**-(_BITS + 1)
        parts.append(cut(values, scale))
    return parts


def products(a, b):
    """Sums over the last axis, a @ b.mT, of stacks (S, m, N) and (S or 1, n, N).

    ``a`` and ``b`` are lists of :func:`slices`. Products of slices that together are below the
    precision of the longer list are left out.
    """
    depth, total = max(len(a), len(b)), 0
    for level in range(depth - 1, -1, -1):
        for i, fine in enumerate(a):
            if 0 <= level - i < len(b):
                other = b[level - i]
                for start in range(0, fine.shape[2], _BLOCK):
                    part = slice(start, start + _BLOCK)
                    total = total + fine[:, :, part] @ other[:, :, part].mT
    return total


def total(values):
    """Sums (...) over the last axis (..., n): the second half is added to the first, and so on."""
    while values.shape[-1] > 1:
        half = (values.shape[-1] + 1) // 2
        head = values[..., :half].copy()
        head[..., :values.shape[-1] - half] += values[..., half:]
        values = head
    return values[..., 0]


@cache
def tanh_table():
    """Hyperbolic tangents (1281,) of -20, -20 + 1/32, ... 20, correctly rounded."""
    with localcontext(prec=40):
        powers = ((Decimal(2 * k) / TANH_STEPS).exp() for k in range(_TANH_END * TANH_STEPS + 1))
        half = np.array([float((power - 1) / (power + 1)) for power in powers])
    return np.concatenate([-half[:0:-1], half])


def tanh(values):
    """Hyperbolic tangents of an array, in place: to the last two bits, and the same everywhere.

    NumPy's differ in the last bit between processors. The value at the nearest entry of a table is
    combined with that of the remainder, at most 1/64, by the addition theorem.
    """
    np.clip(values, -_TANH_END, _TANH_END, out=values)
    entry = np.rint(values * TANH_STEPS)
    values -= entry * (1 / TANH_STEPS)
    there = tanh_table()[entry.astype(np.intp) + _TANH_END * TANH_STEPS]
    square = np.multiply(values, values, out=entry)
    factor = square * (-17 / 315)
    factor += 2 / 15
    factor *= square
    factor += -1 / 3
    factor *= square
    factor *= values
    values += factor
    np.multiply(there, values, out=factor)
    factor += 1
    values += there
    values /= factor
    return values


def eliminate(matrix, count):
    """Schur complement (S, n - count, n - count) of the first ``count`` rows of (S, n, n).

    ``matrix`` is symmetric. Rows that are linear combinations of earlier ones are skipped.
    """
    work = np.ascontiguousarray(matrix.transpose(1, 2, 0))
    _forward(work, count)
    return work[count:, count:].transpose(2, 0, 1)


def solve(matrix, right):
    """Solutions (S, n, m) of symmetric positive definite ``matrix`` (S, n, n) for (S, n, m).

    Unknowns whose row is a linear combination of earlier ones are zero.
    """
    size = matrix.shape[1]
    work = np.ascontiguousarray(np.concatenate([matrix, right], axis=2).transpose(1, 2, 0))
    pivots = _forward(work, size)
    result = work[:, size:]
    for k in range(size - 1, -1, -1):
        result[k] /= pivots[k]
        result[:k] -= work[:k, k, None] * result[k]
    return result.transpose(2, 0, 1)


def _forward(work, count):
    """Gaussian elimination of ``count`` columns of (n, n + m, S) in place; the pivots (S,) each."""
    tiny = [_TINY * work[k, k] for k in range(count)]
    pivots = []
    for k in range(count):
        pivots.append(np.where(work[k, k] > tiny[k], work[k, k], np.inf))
        factor = work[k + 1:, k] / pivots[k]
        work[k + 1:, k + 1:] -= factor[:, None] * work[k, k + 1:]
    return pivots


def triangular(columns):
    """R (n, n) of the QR decomposition, its diagonal >= 0, of the matrix of ``columns`` (n, N).

    Modified Gram-Schmidt. The row of a column that is a linear combination of others is zero.
    """
    left = np.array(columns, np.float64)
    tiny = _TINY * (left * left).sum(1)
    upper = np.zeros((len(left), len(left)))
    for k, column in enumerate(left):
        along = (left[k:] * column).sum(1)
        if along[0] > tiny[k]:
            left[k + 1:] -= (along[1:] / along[0])[:, None] * column
            upper[k, k:] = along / np.sqrt(along[0])
    return upper


def least_squares(columns, wanted):
    """x (n,) that minimises |sum of x[k] * columns[k] - wanted|; (n, N) and (N,)."""
    upper = triangular(np.concatenate([columns, [wanted]]))
    result = np.zeros(len(columns))
    for k in range(len(columns) - 1, -1, -1):
        if upper[k, k]:
            rest = upper[k, -1] - (upper[k, k + 1:-1] * result[k + 1:]).sum()
            result[k] = rest / upper[k, k]
    return result
