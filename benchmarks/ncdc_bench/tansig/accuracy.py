"""Errors of a tan-sigmoid's results from the exact function, and its properties."""

from dataclasses import dataclass

import mpmath
import numpy as np

__all__ = ["Accuracy", "exact_error", "measure"]

# Bound of the error of the double precision tanh, which is below one.
_DOUBLE = 2.0**-50
_CHUNK = 1 << 18    # values at a time


@dataclass(frozen=True)
class Accuracy:
    """Errors of results in ulp, units of 2**-P, P the design's fraction bits.

    Parameters
    ----------
    inputs : int
        Number of measured input values.
    max_ulp : float
        Largest error, at ``worst_input`` (raw), in multi-precision; exact to P 2**(P - 49).
    within_half : int
        Results within half an ulp of the exact value.
    hard_cases : int
        Results close to half an ulp, which multi-precision decided.
    mse : float
        Mean squared error of the real values.
    odd, zero, monotonic : bool
        f(-n) = -f(n) if both were measured, f(0) = 0 if measured, and a larger input never gives a
        smaller result.
    saturated : bool
        Results at the format's ends are opposite, and no result is beyond them; if measured.
    """
    inputs: int
    max_ulp: float
    worst_input: int
    within_half: int
    hard_cases: int
    mse: float
    odd: bool
    zero: bool
    monotonic: bool
    saturated: bool

    @property
    def correctly_rounded(self):
        """Share of the results within half an ulp, 0..1."""
        return self.within_half / self.inputs


def exact_error(n, raw, design):
    """Error of the single result ``raw`` for ``n`` in ulp, signed, by multi-precision."""
    with mpmath.workdps(50):
        exact = mpmath.tanh(mpmath.ldexp(int(n), -design.input.f_bits - 1))
        return mpmath.ldexp(mpmath.ldexp(int(raw), -design.output.f_bits) - exact,
                            design.fraction_bits)


def measure(n, raw, design):
    """Compare results with the exact f(n) = tanh(n / 2), equation (17) with gamma = 1.

    Doubles are used if their error does not matter, else multi-precision.

    Parameters
    ----------
    n : ndarray of int
        Raw inputs in ``design.input``, ascending, none twice.
    raw : ndarray of int
        Raw results in ``design.output``, of the same shape.

    Returns
    -------
    Accuracy

    Raises
    ------
    ValueError
        If ``n`` is empty or not ascending, or the shapes differ.
    """
    n, raw = np.asarray(n), np.asarray(raw)
    if n.shape != raw.shape or n.ndim != 1 or not n.size or (np.diff(n) <= 0).any():
        raise ValueError(f"inputs of shape {n.shape} and results of shape {raw.shape}, "
                         "ascending inputs of the results' shape are needed")
    unit = 2.0**-design.fraction_bits
    margin = _DOUBLE / unit
    largest, worst, within, hard, squares = -1.0, 0, 0, 0, 0.0
    for start in range(0, n.size, _CHUNK):
        part, result = n[start:start + _CHUNK], raw[start:start + _CHUNK]
        error = design.output.real(result) - np.tanh(design.input.real(part) / 2)
        squares += float(np.dot(error, error))
        error = np.abs(error) / unit
        within += int((error <= .5 - margin).sum())
        for k in np.flatnonzero(np.abs(error - .5) < margin):
            hard += 1
            within += bool(abs(exact_error(part[k], result[k], design)) <= .5)
        k = int(error.argmax())
        if error[k] > largest:
            largest, worst = float(error[k]), start + k
    return Accuracy(
        inputs=n.size, max_ulp=float(abs(exact_error(n[worst], raw[worst], design))),
        worst_input=int(n[worst]), within_half=within, hard_cases=hard, mse=squares / n.size,
        monotonic=bool((np.diff(raw) >= 0).all()), **_properties(n, raw, design))


def _properties(n, raw, design):
    """``odd``, ``zero`` and ``saturated`` of :class:`Accuracy`."""
    _, up, down = np.intersect1d(n, -n, assume_unique=True, return_indices=True)
    ends = {int(value): int(result) for value, result in zip(n[[0, -1]], raw[[0, -1]])}
    lo, hi = ends.get(design.input.lo), ends.get(design.input.hi)
    return {"odd": bool((raw[up] == -raw[down]).all()),
            "zero": bool((raw[n == 0] == 0).all()),
            "saturated": (lo is None or hi is None
                          or (lo == -hi and bool((np.abs(raw) <= hi).all())))}
