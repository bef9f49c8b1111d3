"""Rotations as unit quaternions (w, x, y, z), arrays of shape (..., 4)."""

import numpy as np

__all__ = ["matrices", "mean", "multiply", "of_vectors", "running_product"]


def of_vectors(vectors):
    """Quaternions of rotation vectors (..., 3): the axis times the angle in radians."""
    vectors = np.asarray(vectors, np.float64)
    half = np.linalg.norm(vectors, axis=-1, keepdims=True) / 2
    return np.concatenate([np.cos(half), vectors / 2 * np.sinc(half / np.pi)], axis=-1)


def multiply(first, second):
    """Quaternions of ``first`` after ``second``, as a product of their matrices."""
    aw, ax, ay, az = np.moveaxis(first, -1, 0)
    bw, bx, by, bz = np.moveaxis(second, -1, 0)
    return np.stack([aw * bw - ax * bx - ay * by - az * bz, aw * bx + ax * bw + ay * bz - az * by,
                     aw * by - ax * bz + ay * bw + az * bx, aw * bz + ax * by - ay * bx + az * bw],
                    axis=-1)


def running_product(quaternions):
    """Products q[0] q[1] ... q[k] for each k of ``quaternions`` (n, 4)."""
    product, step = np.array(quaternions, np.float64), 1
    while step < len(product):
        product[step:] = multiply(product[:-step], product[step:])
        step *= 2
    return product / np.linalg.norm(product, axis=-1, keepdims=True)


def mean(quaternions, weights):
    """The rotation (4,) from which ``quaternions`` (n, 4) have the least weighted square distance.

    The distance is that of their matrices; q and -q are one rotation.
    """
    return np.linalg.eigh((weights * quaternions.T) @ quaternions)[1][:, -1]


def matrices(quaternions):
    """Rotation matrices (..., 3, 3) of unit quaternions."""
    w, x, y, z = np.moveaxis(np.asarray(quaternions, np.float64), -1, 0)
    rows = ((1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)),
            (2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)),
            (2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
