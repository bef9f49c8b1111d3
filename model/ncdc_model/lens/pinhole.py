"""The pinhole camera: perspective projection of world points to pixels."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Pinhole", "rotation"]


def rotation(alpha, beta, gamma):
    """3x3 rotation of three Euler angles in radians, equations (4)-(7) of the paper."""
    (ca, cb, cg), (sa, sb, sg) = np.cos([alpha, beta, gamma]), np.sin([alpha, beta, gamma])
    about_x = np.array([[1, 0, 0], [0, ca, sa], [0, -sa, ca]])
    about_y = np.array([[cb, 0, -sb], [0, 1, 0], [sb, 0, cb]])
    about_z = np.array([[cg, sg, 0], [-sg, cg, 0], [0, 0, 1]])
    return about_x @ about_y @ about_z


@dataclass(frozen=True)
class Pinhole:
    """Pixels per unit of the image plane and the principal point, equation (2) of the paper.

    Parameters
    ----------
    fx, fy : float
        Focal length in pixels along columns and rows (f delta_x, f delta_y).
    u0, v0 : float
        Principal point in pixels.
    skew : float
        Columns per unit of y; zero for modern sensors.
    """
    fx: float
    fy: float
    u0: float
    v0: float
    skew: float = 0.0

    @property
    def matrix(self):
        """Intrinsic matrix C, 3x3."""
        return np.array([[self.fx, self.skew, self.u0], [0, self.fy, self.v0], [0, 0, 1.0]])

    def distort(self, x, y):
        """Pixel of a point (x, y) of the plane at distance 1."""
        x, y = np.asarray(x, np.float64), np.asarray(y, np.float64)
        return self.fx * x + self.skew * y + self.u0, self.fy * y + self.v0

    def undistort(self, x, y):
        """Point of the plane at distance 1 of a pixel."""
        b = (np.asarray(y, np.float64) - self.v0) / self.fy
        return (np.asarray(x, np.float64) - self.u0 - self.skew * b) / self.fx, b

    def project(self, points, turn=np.eye(3), shift=(0, 0, 0)):
        """Pixels of world ``points`` (..., 3), equations (1), (3) and (8) of the paper.

        ``turn`` is the 3x3 rotation and ``shift`` the translation from world to camera.
        The result is not-a-number for points that are not in front of the camera.
        """
        x, y, z = np.moveaxis(np.asarray(points, np.float64) @ turn.T + np.asarray(shift), -1, 0)
        z = np.where(z > 0, z, np.nan)
        return self.distort(x / z, y / z)
