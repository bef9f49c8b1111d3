"""Numeric inverses: safeguarded Newton iterations over whole arrays."""

import numpy as np

__all__ = ["monotone_inverse", "monotone_limit", "planar_inverse"]


def monotone_limit(slope, stop, steps=4096):
    """Largest argument up to ``stop`` before which ``slope`` stays positive."""
    grid = np.linspace(0.0, stop, steps + 1)
    bad = np.flatnonzero(slope(grid) <= 0)
    return float(grid[max(bad[0] - 1, 0)]) if bad.size else float(stop)


def monotone_inverse(function, slope, target, limit, iterations=60):
    """Solve function(r) = target for r in [0, limit], element by element.

    Newton's step is used if it stays inside the bracket of the root, else bisection, so
    that any increasing ``function`` converges. Not-a-number outside function(0)..function(limit).
    """
    target = np.asarray(target, np.float64)
    lo, hi = np.zeros_like(target), np.full_like(target, limit)
    inside = (target >= function(lo)) & (target <= function(hi))
    r = np.clip(target, 0.0, limit)
    for _ in range(iterations):
        error = function(r) - target
        lo, hi = np.where(error < 0, r, lo), np.where(error > 0, r, hi)
        with np.errstate(divide="ignore", invalid="ignore"):
            after = r - error / slope(r)
        after = np.where((after >= lo) & (after <= hi), after, (lo + hi) / 2)
        moved = np.abs(after - r)[inside]
        r = after
        if not moved.size or moved.max() <= 4e-16 * max(1.0, limit):
            break
    return np.where(inside, r, np.nan)


def planar_inverse(function, x, y, scale=1.0, iterations=30):
    """Solve function(a, b) = (x, y) in the plane, element by element, starting at (x, y).

    Newton's method with a central-difference Jacobian; a step that does not reduce the
    error is halved. ``scale`` is the size of one unit of length in the problem (1 for
    normalised coordinates, about 500 for pixels). The result is not-a-number without a solution
    to within 1e-9 ``scale``.
    """
    x, y = (np.array(value, np.float64) for value in np.broadcast_arrays(x, y))
    a, b, h = x.copy(), y.copy(), 1e-6 * scale
    with np.errstate(all="ignore"):
        fx, fy = function(a, b)
        error = np.hypot(fx - x, fy - y)
        for _ in range(iterations):
            if np.nanmax(error, initial=0.0) <= 1e-13 * scale:
                break
            right, left, below, above = (function(a + da, b + db)
                                         for da, db in ((h, 0), (-h, 0), (0, h), (0, -h)))
            xa, ya = (right[0] - left[0]) / (2 * h), (right[1] - left[1]) / (2 * h)
            xb, yb = (below[0] - above[0]) / (2 * h), (below[1] - above[1]) / (2 * h)
            determinant = xa * yb - xb * ya
            da = ((fx - x) * yb - (fy - y) * xb) / determinant
            db = ((fy - y) * xa - (fx - x) * ya) / determinant
            gained, step = np.zeros(x.shape, bool), np.ones(x.shape)
            for _ in range(8):
                na, nb = a - step * da, b - step * db
                nx, ny = function(na, nb)
                trial = np.hypot(nx - x, ny - y)
                take = ~gained & (trial < error)
                a, b = np.where(take, na, a), np.where(take, nb, b)
                fx, fy = np.where(take, nx, fx), np.where(take, ny, fy)
                error = np.where(take, trial, error)
                gained |= take | (error <= 1e-13 * scale) | ~np.isfinite(trial)
                if gained.all():
                    break
                step = np.where(gained, step, step / 2)
            if not take.any() and not gained.any():
                break
        solved = error <= 1e-9 * scale
    return np.where(solved, a, np.nan), np.where(solved, b, np.nan)
