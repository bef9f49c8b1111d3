"""Lens models of OpenCV as maps: pose and lens of a camera fitted to a flat target."""

import numpy as np
from scipy.optimize import least_squares

__all__ = ["fit_projection"]


def fit_projection(points, project, stages, starts=((1.0, 1e-4),)):
    """Least-squares fit of a camera, its lens and its pose relative to the corrected picture.

    The corrected picture serves as a flat target at z = 0, two units wide, as in OpenCV's
    calibration: parameters are its rotation vector and translation, then
    the camera's focal lengths and principal point, then the coefficients of the lens.

    Parameters
    ----------
    points : Problem
    project : callable
        ``project(target, pose, camera, lens)`` gives pixels (N, 2) and their derivatives
        (2 N, parameters), x and y of each point in turn; ``target`` has shape (N, 3).
    stages : sequence of sequence of int
        Coefficients of the lens that each stage of the fit adds; all others are zero.
    starts : sequence of (float, float)
        Distance of the target at the start, in units of half its width, and relative change of
        the cost at which a stage before the last ends. The result is the best fit of all starts,
        since the larger models have several minima.

    Returns
    -------
    callable
        (u, v) to (x', y').
    """
    width, height = points.geometry.corrected
    middle, unit = np.array([(width - 1) / 2, (height - 1) / 2]), width / 2
    wanted = np.stack([points.x, points.y], axis=1)

    def flat(u, v):
        return np.stack([(np.ravel(u) - middle[0]) / unit, (np.ravel(v) - middle[1]) / unit,
                         np.zeros(np.size(u))], axis=1)

    target = flat(points.u, points.v)
    near = np.argsort(np.hypot(*target[:, :2].T), kind="stable")[:max(12, len(points) // 20)]
    affine = np.linalg.lstsq(np.column_stack([target[near, :2], np.ones(len(near))]),
                             wanted[near], rcond=None)[0]
    focal = np.sqrt(abs(np.linalg.det(affine[:2])))
    count = 1 + max(k for stage in stages for k in stage)

    def projected(values, at=target):
        return project(at, values[:6], values[6:10], values[10:])

    def descend(distance, tolerance):
        start = np.concatenate([[0, 0, 0, 0, 0, distance, distance * focal, distance * focal,
                                 *affine[2]], np.zeros(count)])
        return _descend(projected, wanted, start, stages, tolerance)

    parameters = min((descend(*start) for start in starts), key=lambda fit: fit[0])[1]

    def back_map(u, v):
        pixels, _ = projected(parameters, flat(u, v))
        return pixels[:, 0].reshape(np.shape(u)), pixels[:, 1].reshape(np.shape(u))
    return back_map


def _descend(projected, wanted, start, stages, tolerance):
    """Cost and parameters after the last stage, from the parameters ``start``.

    ``projected(parameters)`` gives pixels and derivatives; the pixels ``wanted`` have shape (N, 2).
    """
    parameters, free = start.copy(), list(range(10))
    for stage in stages:
        free = free + [10 + k for k in stage]

        def evaluate(values, part):
            trial = parameters.copy()
            trial[free] = values
            return projected(trial)[part]
        fit = least_squares(
            lambda values: (evaluate(values, 0) - wanted).ravel(), parameters[free],
            jac=lambda values: evaluate(values, 1)[:, free], method="lm", x_scale="jac",
            ftol=1e-9 if stage is stages[-1] else tolerance, xtol=1e-12, gtol=1e-14,
            max_nfev=1000)
        parameters[free] = fit.x
    return fit.cost, parameters
