"""Derivatives of a smooth camera's pixels by its parameters, in closed form."""

import numpy as np

from ncdc_model.calibration.smooth_vector import LENS, MAX_RATIO, TERMS, crosses, planes_of
from ncdc_model.lens import TiltedSensor

__all__ = ["derivatives"]


def derivatives(vector, cells, owner):
    """Derivatives (m, n, 2) of the pixels of points by the parameters of ``vector`` (m,).

    Parameters
    ----------
    vector : ndarray
        Of :mod:`ncdc_model.calibration.smooth_vector`.
    cells : ndarray, shape (n, 2)
        Columns and rows of the points on their targets.
    owner : ndarray of int, shape (n,)
        Number of each point's photo.
    """
    planes, (lens, poses) = planes_of(vector), np.split(vector, [LENS])
    seen = (planes[owner] @ np.column_stack([cells, np.ones(len(cells))])[:, :, None])[:, :, 0]
    flat, by_ray, powers = _radial(lens[3:3 + TERMS], seen)
    parted, by_flat, by_decentring = _decentred(lens[3 + TERMS:9 + TERMS], flat)
    tilt, aspect, ratio = TiltedSensor(tuple(lens[9 + TERMS:11 + TERMS])), lens[-2], lens[-1]
    at, by_parted, by_tilt = _tilted(tilt, parted)
    focal, stretch = lens[0], 1 + MAX_RATIO[0] * np.tanh(aspect / MAX_RATIO[0])
    pixels = focal * np.array([1, stretch])
    to_pixels = by_parted * pixels[:, None]                     # (n, 2, 2), from the parted point
    from_flat = to_pixels @ by_flat
    from_ray = from_flat @ by_ray                               # (n, 2, 3)
    rows = np.zeros((len(vector), len(cells), 2))
    rows[0] = at * (1, stretch)
    rows[1, :, 0] = rows[2, :, 1] = 1
    rows[3:3 + TERMS] = (from_flat @ powers).transpose(2, 0, 1)
    rows[3 + TERMS:9 + TERMS] = (to_pixels @ by_decentring).transpose(2, 0, 1)
    rows[9 + TERMS:11 + TERMS] = by_tilt * pixels
    rows[LENS - 2, :, 1] = focal * at[:, 1] / np.cosh(aspect / MAX_RATIO[0])**2
    change = 1 / ((1 + MAX_RATIO[1] * np.tanh(ratio / MAX_RATIO[1]))
                  * np.cosh(ratio / MAX_RATIO[1])**2)           # of a row's distance, in its parts
    along = planes[owner, :, 1] * (cells[:, 1:] * change)
    rows[LENS - 1] = (from_ray @ along[:, :, None])[:, :, 0]
    # A pose turns the target about its origin: the turned vector's derivative is a cross product.
    turned = seen - planes[owner, :, 2]
    moves = np.cross(_left_jacobians(poses.reshape(-1, 6)[:, :3])[owner].transpose(2, 0, 1), turned)
    by_pose = np.concatenate([(from_ray @ moves.transpose(1, 2, 0)), from_ray], axis=2)
    rows[LENS + 6 * owner + np.arange(6)[:, None], np.arange(len(cells))] = by_pose.transpose(
        2, 0, 1)
    return rows


def _radial(k, rays):
    """Points (n, 2) of the plane, their derivatives by the ``rays`` (n, 3), and by each term."""
    x, y, z = rays.T
    across = np.maximum(np.hypot(x, y), 1e-12)
    angle, square = np.arctan2(across, z), across**2 + z**2
    powers = angle[:, None] ** np.arange(1, 2 * len(k) + 2, 2)      # of the angle: 1, 3, 5, ...
    radius = powers @ [1, *k]
    slope = (powers * np.arange(1, 2 * len(k) + 2, 2)) @ [1, *k] / angle
    unit = rays[:, :2] / across[:, None]
    # The radius changes with the angle, the direction with the position across.
    outwards = np.column_stack([unit * (slope * z / square)[:, None], -slope * across / square])
    by_ray = unit[:, :, None] * outwards[:, None]
    sideways = np.stack([-unit[:, 1], unit[:, 0]], axis=1)
    by_ray[:, :, :2] += (sideways * (radius / across)[:, None])[:, :, None] * sideways[:, None]
    return unit * radius[:, None], by_ray, unit[:, :, None] * powers[:, None, 1:]


def _decentred(parameters, points):
    """Points (n, 2) after decentring and thin prism, their derivatives by ``points`` and by the
    six parameters."""
    p0, p1, p2, p3, s0, s2 = parameters
    a, b = points.T
    q = a * a + b * b
    higher, slope = 1 + p2 * q + p3 * q * q, p2 + 2 * p3 * q
    of_p0 = np.stack([q + 2 * a * a, 2 * a * b], axis=1)
    of_p1 = np.stack([2 * a * b, q + 2 * b * b], axis=1)
    along = p0 * of_p0 + p1 * of_p1
    prism = np.array([s0, s2])
    radial = 2 * points                                             # of q
    by_points = (along * slope[:, None] + prism)[:, :, None] * radial[:, None]
    mixed = 2 * (p0 * b + p1 * a) * higher
    by_points[:, 0, 0] += 1 + (6 * p0 * a + 2 * p1 * b) * higher
    by_points[:, 0, 1] += mixed
    by_points[:, 1, 0] += mixed
    by_points[:, 1, 1] += 1 + (2 * p0 * a + 6 * p1 * b) * higher
    nothing = np.zeros_like(q)
    by_parameters = np.stack([
        of_p0 * higher[:, None], of_p1 * higher[:, None], along * q[:, None],
        along * (q * q)[:, None], np.stack([q, nothing], axis=1), np.stack([nothing, q], axis=1)],
        axis=2)
    return points + along * higher[:, None] + prism * q[:, None], by_points, by_parameters


def _tilted(tilt, points):
    """Points (n, 2) on a :class:`TiltedSensor`, their derivatives by ``points`` (n, 2, 2) and by
    both angles (2, n, 2)."""
    matrix = tilt.matrix
    before = np.column_stack([points, np.ones(len(points))])
    weight = before @ matrix[2]
    at = before @ matrix[:2].T / weight[:, None]
    by_points = (matrix[:2, :2] - at[:, :, None] * matrix[2, :2]) / weight[:, None, None]
    moved = before @ tilt.changes.swapaxes(1, 2)
    return at, by_points, (moved[:, :, :2] - at * moved[:, :, 2:]) / weight[:, None]


def _left_jacobians(turns):
    """Matrices (photos, 3, 3) that take changes of rotation vectors to those of the rotation."""
    angle, cross = crosses(turns)
    return (np.eye(3) + (1 - np.cos(angle)) / angle**2 * cross
            + (angle - np.sin(angle)) / angle**3 * (cross @ cross))
