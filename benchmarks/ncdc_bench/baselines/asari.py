"""Asari's radial polynomial, the paper's polynomial back-map (PBM)."""

import numpy as np
from scipy.optimize import least_squares

__all__ = ["fit_asari"]


def fit_asari(points, order, shared=True):
    """Polynomial back-map of ``order`` N, least squares on the points.

    Equations (9)-(11) of the paper, with rho and theta about (u0, v0)::

        (x', y') = (x0, y0) + sum over n = 0..N of a_n rho^n (cos theta, sin theta)

    The centre is fitted with the coefficients, which are linear and eliminated.

    Parameters
    ----------
    points : Problem
    order : int
        N; the paper has 6 to 8.
    shared : bool
        One centre for both pictures, (x0, y0) = (u0, v0), as in the paper; else one for each.

    Returns
    -------
    callable
        (u, v) to (x', y').
    """
    size = np.array(points.geometry.corrected)
    unit = size[0] / 2
    targets = points.targets / unit

    def radial(u, v, centre):
        """Columns (2, N + 1, points) that the coefficients multiply; lengths in ``unit``."""
        du, dv = u / unit - centre[0], v / unit - centre[1]
        rho = np.hypot(du, dv)
        direction = np.stack([du, dv]) / np.maximum(rho, 1e-12)
        return direction[:, None] * rho ** np.arange(order + 1)[:, None]

    def solve(centre):
        """Coefficients, then (x0, y0), and the residuals of both axes."""
        columns = radial(points.u, points.v, centre)
        offset = np.repeat(np.eye(2), len(points), axis=1)
        if shared:
            system, wanted = np.hstack(columns), (targets - centre[:, None]).ravel()
        else:
            system, wanted = np.concatenate([np.hstack(columns), offset]), targets.ravel()
        solution = np.linalg.lstsq(system.T, wanted, rcond=None)[0]
        end = centre if shared else solution[order + 1:]
        return solution[:order + 1], end, solution @ system - wanted

    middle = (size - 1) / 2 / unit
    centre = least_squares(lambda c: solve(c)[2], middle, method="lm", diff_step=1e-5,
                           xtol=1e-13, ftol=1e-13, gtol=1e-13).x
    coefficients, end, _ = solve(centre)

    def back_map(u, v):
        u, v = np.asarray(u, np.float64), np.asarray(v, np.float64)
        du, dv = u / unit - centre[0], v / unit - centre[1]
        rho = np.hypot(du, dv)
        ratio = np.polynomial.polynomial.polyval(rho, coefficients) / np.maximum(rho, 1e-12)
        return unit * (end[0] + du * ratio), unit * (end[1] + dv * ratio)
    return back_map
