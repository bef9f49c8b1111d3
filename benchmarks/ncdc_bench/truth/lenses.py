"""Cameras of exactly known rays, 1280x960, each with one manufacturing flaw or several.

No model of :mod:`ncdc_model` is used: what is measured must not be described by what measures it.
"""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy.interpolate import RectBivariateSpline

__all__ = ["LENSES", "SIZE", "TrueLens"]

SIZE = 1280, 960
_MIDDLE = (SIZE[0] - 1) / 2, (SIZE[1] - 1) / 2
_GRID = 8              # pixels between the exact inverses, splines in between
_OUT = 4               # pixels around the picture that the splines cover too
_STEPS = 60            # of Newton's method


@dataclass(frozen=True)
class TrueLens:
    """A lens as a function of the view angle, and the flaws of its camera.

    Parameters
    ----------
    name : str
    kind : str
        ``equidistant``: radius f theta; ``equisolid``: 2 f sin(theta / 2); ``opencv``: OpenCV's
        perspective model with the coefficients ``k``.
    focal : float
        f in pixels.
    centre : (float, float)
        Pixel of the optical axis.
    k : tuple
        OpenCV's k1, k2, p1, p2, k3.
    tilt : (float, float)
        Angles of the sensor about x and y in radians, OpenCV's tau.
    aspect : float
        Height of a pixel's picture over its width: y is multiplied by it.
    bumps : tuple of (x, y, dx, dy, sigma)
        Gaussian displacements in pixels: middle, vector, width.
    """
    name: str
    kind: str
    focal: float
    centre: tuple = (_MIDDLE[0] + 3, _MIDDLE[1] - 4)
    k: tuple = (0.0,) * 5
    tilt: tuple = (0.0, 0.0)
    aspect: float = 1.0
    bumps: tuple = ()

    def project(self, rays):
        """Pixels (n, 2) of the directions ``rays`` (n, 3)."""
        x, y, z = np.asarray(rays, np.float64).T
        across = np.hypot(x, y)
        return self.of_angles(np.stack([x, y], axis=1)
                              * (np.arctan2(across, z) / np.maximum(across, 1e-300))[:, None])

    def of_angles(self, angles):
        """Pixels (n, 2) of directions given as view angle times unit vector (n, 2), radians."""
        theta = np.linalg.norm(angles, axis=1)
        if self.kind == "equidistant":
            plane = angles
        elif self.kind == "equisolid":
            plane = angles * np.sinc(theta / 2 / np.pi)[:, None]
        else:
            ideal = angles * (np.tan(np.minimum(theta, 1.5)) / np.maximum(theta, 1e-300))[:, None]
            plane = cv2.projectPoints(np.column_stack([ideal, np.ones(len(ideal))])[:, None],
                                      np.zeros(3), np.zeros(3), np.eye(3),
                                      np.array(self.k))[0].reshape(-1, 2)
        if any(self.tilt):
            plane = cv2.projectPoints(
                np.column_stack([plane, np.ones(len(plane))])[:, None], np.zeros(3), np.zeros(3),
                np.eye(3), np.array([0.0] * 12 + list(self.tilt)))[0].reshape(-1, 2)
        pixels = self.focal * plane * (1, self.aspect) + self.centre
        moved = pixels.copy()
        for x, y, dx, dy, sigma in self.bumps:
            bump = np.exp(-((pixels - (x, y))**2).sum(axis=1) / (2 * sigma**2))
            moved += bump[:, None] * (dx, dy)
        return moved

    def angles(self, columns, rows):
        """Directions as :meth:`of_angles` takes them of the pixels in ``columns`` (m,) and ``rows``
        (n,), shape (2, n, m)."""
        return np.stack([spline(rows, columns) for spline in self._splines])

    def angles_at(self, xy):
        """Directions (n, 2) of the pixels ``xy`` (n, 2)."""
        return np.stack([spline.ev(xy[:, 1], xy[:, 0]) for spline in self._splines], axis=1)

    @cached_property
    def _splines(self):
        """Both parts of the direction over rows and columns, exact on a grid."""
        x = np.arange(-_OUT, SIZE[0] + _OUT + 1, _GRID, dtype=np.float64)
        y = np.arange(-_OUT, SIZE[1] + _OUT + 1, _GRID, dtype=np.float64)
        goal = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        # Of OpenCV's model the way in must not lead over its fold.
        at = (goal - self.centre) / self.focal * (0.6 if self.kind == "opencv" else 1)
        h = 1e-6
        for _ in range(_STEPS):
            off = self.of_angles(at) - goal
            a, b = ((self.of_angles(at + step) - self.of_angles(at - step)) / (2 * h)
                    for step in (np.array([h, 0]), np.array([0, h])))
            move = np.linalg.solve(np.stack([a, b], axis=2), off[:, :, None])[:, :, 0]
            at -= np.clip(move, -0.2, 0.2)
            if np.abs(off).max() < 1e-9:
                break
        if not np.abs(off).max() < 1e-6:
            raise ValueError(f"lens {self.name} has no ray for some pixels")
        return [RectBivariateSpline(y, x, part.reshape(len(y), len(x)), kx=5, ky=5)
                for part in at.T]


def _wide(degrees, kind="equidistant"):
    half = np.radians(degrees) / 2
    return SIZE[0] / 2 / {"equidistant": half, "equisolid": 2 * np.sin(half / 2)}[kind]


_BUMPS = (430.0, 360.0, 2.9, 2.1, 70.0), (860.0, 560.0, -1.6, 1.9, 110.0)
LENSES = {lens.name: lens for lens in (
    TrueLens("equidistant 105", "equidistant", _wide(105)),
    TrueLens("equidistant 120", "equidistant", _wide(120)),
    TrueLens("equisolid 110", "equisolid", _wide(110, "equisolid")),
    TrueLens("decentred", "opencv", 760.0, k=(-.28, .09, .006, -.005, -.012)),
    TrueLens("tilted sensor", "equidistant", _wide(105), tilt=(.04, -.03)),
    TrueLens("centre off", "equidistant", _wide(105),
             (_MIDDLE[0] + .05 * SIZE[0], _MIDDLE[1] - .05 * SIZE[1])),
    TrueLens("pixels 1:1.06", "equidistant", _wide(105), _MIDDLE, aspect=1.06),
    TrueLens("all flaws", "opencv", 800.0, (_MIDDLE[0] + 38, _MIDDLE[1] - 27),
             (-.25, .07, .004, -.003, -.008), (.03, -.02), 1.03),
    TrueLens("bumps", "equidistant", _wide(105), bumps=_BUMPS),
    TrueLens("equidistant 126", "equidistant", _wide(126)),
    TrueLens("equidistant 140", "equidistant", _wide(140)),
    TrueLens("equidistant 150", "equidistant", _wide(150)))}
