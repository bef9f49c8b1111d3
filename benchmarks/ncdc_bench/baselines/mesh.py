"""Meshes of nodes over the corrected picture, as commercial cores use them."""

import numpy as np
from scipy.interpolate import BSpline

from ncdc_bench.baselines.polyharmonic import fit_polyharmonic

__all__ = ["fit_bicubic_mesh", "fit_bilinear_mesh"]


def fit_bilinear_mesh(points, step):
    """Bilinear interpolation between nodes every ``step`` pixels.

    There are more nodes than points: they are taken from the smoothing spline of
    :func:`fit_polyharmonic`.

    Returns
    -------
    callable
        (u, v) to (x', y').
    """
    columns, rows = (-(-(size - 1) // step) + 1 for size in points.geometry.corrected)
    nodes = np.stack(fit_polyharmonic(points)(*np.meshgrid(step * np.arange(columns),
                                                           step * np.arange(rows))))

    def back_map(u, v):
        u, v = np.asarray(u, np.float64) / step, np.asarray(v, np.float64) / step
        i = np.clip(np.floor(u).astype(int), 0, columns - 2)
        j = np.clip(np.floor(v).astype(int), 0, rows - 2)
        fu, fv = u - i, v - j
        upper = nodes[:, j, i] * (1 - fu) + nodes[:, j, i + 1] * fu
        lower = nodes[:, j + 1, i] * (1 - fu) + nodes[:, j + 1, i + 1] * fu
        return tuple(upper * (1 - fv) + lower * fv)
    return back_map


def fit_bicubic_mesh(points, step):
    """Bicubic B-spline with knots every ``step`` pixels, least squares on the points.

    A penalty on the third differences of the coefficients along rows and columns determines those
    without points; its weight minimises the generalised cross-validation.

    Returns
    -------
    callable
        (u, v) to (x', y').
    """
    knots = [step * np.arange(-3.0, -(-(size - 1) // step) + 4)
             for size in points.geometry.corrected]
    counts = [len(knot) - 4 for knot in knots]

    def basis(values, axis):
        inside = np.clip(values, 0, knots[axis][-4])
        return BSpline.design_matrix(inside, knots[axis], 3).toarray()

    across, down = basis(points.u, 0), basis(points.v, 1)
    design = (down[:, :, None] * across[:, None, :]).reshape(len(points), -1)
    along_u, along_v = (np.diff(np.eye(count), 3, axis=0) for count in counts)
    penalty = (np.kron(np.eye(counts[1]), along_u.T @ along_u)
               + np.kron(along_v.T @ along_v, np.eye(counts[0])))
    normal, targets = design.T @ design, points.targets.T

    def solve(weight):
        return np.linalg.solve(normal + weight * penalty, np.column_stack([design.T @ targets,
                                                                           normal]))

    def score(weight):
        solution = solve(weight)
        used = np.trace(solution[:, 2:])
        return ((design @ solution[:, :2] - targets)**2).sum() / (len(points) - used)**2
    coefficients = solve(min(np.geomspace(1e-10, 1e2, 61), key=score))[:, :2]
    coefficients = coefficients.T.reshape(2, counts[1], counts[0])

    def back_map(u, v):
        across, down = basis(np.ravel(u), 0), basis(np.ravel(v), 1)
        return tuple(((down @ plane) * across).sum(1).reshape(np.shape(u))
                     for plane in coefficients)
    return back_map
