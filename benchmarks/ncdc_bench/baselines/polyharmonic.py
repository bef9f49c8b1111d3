"""Smoothing spline through scattered points; the points determine its smoothness."""

import numpy as np

__all__ = ["fit_polyharmonic"]


def fit_polyharmonic(points, order=4, block=4096):
    """Polyharmonic smoothing spline of the points, both coordinates with one smoothness.

    It minimises the squared errors plus lambda times the squared derivatives of ``order`` (2: thin
    plate); lambda minimises the generalised cross-validation. Polynomials below ``order`` are
    reproduced exactly.

    Parameters
    ----------
    points : Problem
    order : int

    Returns
    -------
    callable
        (u, v) to (x', y').
    """
    size = points.geometry.corrected
    unit, middle = size[0] / 2, (np.array(size) - 1) / 2
    powers = [(i, n - i) for n in range(order) for i in range(n + 1)]

    def normalised(u, v):
        return np.stack([(np.ravel(u) - middle[0]) / unit, (np.ravel(v) - middle[1]) / unit])

    def polynomials(at):
        return np.stack([at[0]**i * at[1]**j for i, j in powers], axis=1)

    def kernel(at, knots):
        square = ((at[:, :, None] - knots[:, None, :])**2).sum(0)
        # r^(2 m - 2) log r, with the sign of a positive form.
        return (-1)**order / 2 * square**(order - 1) * np.log(np.maximum(square, 1e-300))

    knots, targets = normalised(points.u, points.v), points.targets.T
    form, free = kernel(knots, knots), polynomials(knots)
    q, _ = np.linalg.qr(free, mode="complete")
    rest = q[:, len(powers):]
    values, vectors = np.linalg.eigh(rest.T @ form @ rest)
    values = np.maximum(values, 0)
    turned = vectors.T @ rest.T @ targets

    def score(smooth):
        share = smooth / (values + smooth)
        return ((share[:, None] * turned)**2).sum() / share.sum()**2
    smooth = min(np.geomspace(1e-12, 1e2, 141) * values[-1], key=score)
    weights = rest @ vectors @ (turned / (values + smooth)[:, None])
    tail = np.linalg.lstsq(free, targets - form @ weights - smooth * weights, rcond=None)[0]

    def back_map(u, v):
        at = normalised(u, v)
        result = np.concatenate([
            kernel(at[:, k:k + block], knots) @ weights + polynomials(at[:, k:k + block]) @ tail
            for k in range(0, at.shape[1], block)])
        return result[:, 0].reshape(np.shape(u)), result[:, 1].reshape(np.shape(u))
    return back_map
