"""Manufacturing flaws: decentred elements, a tilted sensor, an asymmetric lens surface."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ncdc_model.lens.inverse import planar_inverse

__all__ = ["AsymmetricSurface", "BrownWeng", "TiltedSensor"]


@dataclass(frozen=True)
class BrownWeng:
    """Radial, decentring and thin prism distortion, equations (12)-(14) of the paper.

    With (x, y) relative to ``centre`` and q = x^2 + y^2::

        xd = x (1 + k0 q + k1 q^2 + ...)
             + (p0 (q + 2 x^2) + 2 p1 x y) (1 + p2 q + ...) + s0 q + s1 q^2
        yd = y (1 + k0 q + k1 q^2 + ...)
             + (2 p0 x y + p1 (q + 2 y^2)) (1 + p2 q + ...) + s2 q + s3 q^2

    The thin prism terms s are Weng's. The units of the coefficients are those of the points.
    ``undistort`` gives not-a-number without an inverse, as beyond the fold of the model.
    """
    k: tuple = ()
    p: tuple = (0.0, 0.0)
    s: tuple = (0.0, 0.0, 0.0, 0.0)
    centre: tuple = (0.0, 0.0)
    scale: float = 1.0              # typical length in the units of the points, for the inverse

    def distort(self, x, y):
        """Distorted point of the ideal point (x, y)."""
        cx, cy = self.centre
        x, y = np.asarray(x, np.float64) - cx, np.asarray(y, np.float64) - cy
        q = x * x + y * y
        radial = _powers(q, (1.0, *self.k))
        higher = _powers(q, (1.0, *self.p[2:]))
        p0, p1 = self.p[:2]
        s0, s1, s2, s3 = self.s
        xt, yt = p0 * (q + 2 * x * x) + 2 * p1 * x * y, 2 * p0 * x * y + p1 * (q + 2 * y * y)
        return (cx + x * radial + xt * higher + q * (s0 + s1 * q),
                cy + y * radial + yt * higher + q * (s2 + s3 * q))

    def undistort(self, x, y):
        """Ideal point of the distorted point (x, y)."""
        return planar_inverse(self.distort, x, y, self.scale)


def _powers(q, coefficients):
    value = np.full_like(q, coefficients[-1])
    for coefficient in coefficients[-2::-1]:
        value = value * q + coefficient
    return value


@dataclass(frozen=True)
class TiltedSensor:
    """A sensor that is not parallel to the lens: projective, OpenCV's tilt of two angles.

    ``angles`` are radians about the x and the y axis; coordinates are normalised (distance 1).
    """
    angles: tuple = (0.0, 0.0)

    @cached_property
    def matrix(self):
        """3x3 homography from the parallel to the tilted sensor."""
        (ca, cb), (sa, sb) = np.cos(self.angles), np.sin(self.angles)
        return np.array([[ca, 0, 0], [-sa * sb, cb, 0], [sb, -cb * sa, cb * ca]])

    @property
    def changes(self):
        """Derivatives (2, 3, 3) of the matrix by both angles."""
        (ca, cb), (sa, sb) = np.cos(self.angles), np.sin(self.angles)
        return np.array([[[-sa, 0, 0], [-ca * sb, 0, 0], [0, -cb * ca, -cb * sa]],
                         [[0, 0, 0], [-sa * cb, -sb, 0], [cb, sb * sa, -sb * ca]]])

    def distort(self, x, y):
        """Point on the tilted sensor of a point on the parallel one."""
        return _project(self.matrix, x, y)

    def undistort(self, x, y):
        """Point on the parallel sensor of a point on the tilted one."""
        return _project(np.linalg.inv(self.matrix), x, y)


def _project(matrix, x, y):
    x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
    w = matrix[2, 0] * x + matrix[2, 1] * y + matrix[2, 2]
    w = np.where(w > 0, w, np.nan)
    return ((matrix[0, 0] * x + matrix[0, 1] * y + matrix[0, 2]) / w,
            (matrix[1, 0] * x + matrix[1, 1] * y + matrix[1, 2]) / w)


@dataclass(frozen=True)
class AsymmetricSurface:
    """Smooth asymmetric displacement in pixels: bumps and a polynomial.

    With X = (x - cx) / (W/2), Y = (y - cy) / (W/2), r2 = X^2 + Y^2, (cx, cy) the image's middle::

        (dx, dy) = scale ( sum over bumps of vector exp(-d^2 / (2 sigma^2))
                           + sum over i of poly[:, i] B_i )
        d^2 = (X - bx)^2 + (Y - by H/W)^2
        B = X^2, XY, Y^2, X r2, Y r2, X^3 - 3 X Y^2, 3 X^2 Y - Y^3, X^2 r2, X Y r2

    Parameters
    ----------
    size : (int, int)
        W, H of the distorted image.
    scale : float
        Pixels.
    bump_centres, bump_sigmas, bump_vectors : tuple
        (bx, by), sigma and (vx, vy) of each bump.
    poly : tuple
        Two rows of nine coefficients, for dx and dy; empty for none.
    """
    size: tuple
    scale: float = 0.0
    bump_centres: tuple = ()
    bump_sigmas: tuple = ()
    bump_vectors: tuple = ()
    poly: tuple = ()

    def distort(self, x, y):
        """Displaced pixel."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        if not self.scale:
            return x, y
        width, height = self.size
        dx, dy = 0.0, 0.0
        px, py = (x - (width - 1) / 2) / (width / 2), (y - (height - 1) / 2) / (width / 2)
        for (bx, by), sigma, (vx, vy) in zip(self.bump_centres, self.bump_sigmas,
                                             self.bump_vectors):
            distance = (px - bx)**2 + (py - by * height / width)**2
            bump = np.exp(-distance / (2 * sigma * sigma))
            dx, dy = dx + vx * bump, dy + vy * bump
        if self.poly:
            xx, xy, yy = px * px, px * py, py * py
            r2 = xx + yy
            basis = (xx, xy, yy, px * r2, py * r2, px * (xx - 3 * yy), py * (3 * xx - yy),
                     xx * r2, xy * r2)
            for cx, cy, term in zip(*self.poly, basis):
                dx, dy = dx + cx * term, dy + cy * term
        return x + self.scale * dx, y + self.scale * dy

    def undistort(self, x, y):
        """Pixel that is displaced to (x, y)."""
        if not self.scale:
            return np.asarray(x, np.float64), np.asarray(y, np.float64)
        return planar_inverse(self.distort, x, y, self.size[0] / 2)
