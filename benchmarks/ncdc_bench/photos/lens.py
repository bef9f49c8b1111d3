"""The lens and the page of rendered photos in closed form, and how far points are off flat."""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from ncdc_model.lens import rotation

__all__ = ["Lens", "Plane"]

_ASKEW = 0.07          # steps across, for each along, of the seam of two sheets
_CUT = 0.5             # steps from it: nearer points may be cut by it


@dataclass(frozen=True)
class Lens:
    """Equisolid lens, r = 2 f sin(t / 2): another one than those that calibration fits.

    ``focal``: pixels; ``middle`` (x, y): where its axis meets the picture.
    """
    focal: float
    middle: tuple

    def plane(self, x, y):
        """Points of the plane at distance 1 that the pixels (x, y) see, two arrays."""
        x, y = (x - self.middle[0]) / self.focal, (y - self.middle[1]) / self.focal
        radius = np.hypot(x, y)
        slope = np.tan(2 * np.arcsin(np.clip(radius / 2, 0, 0.7))) / np.maximum(radius, 1e-9)
        return slope * x, slope * y

    def pixels(self, rays):
        """Pixels (n, 2) of directions (n, 3)."""
        angle = np.arctan2(np.hypot(rays[:, 0], rays[:, 1]), rays[:, 2])
        unit = rays[:, :2] / np.maximum(np.hypot(rays[:, 0], rays[:, 1]), 1e-12)[:, None]
        return np.array(self.middle) + self.focal * 2 * np.sin(angle / 2)[:, None] * unit

    def off_flat(self, index, xy):
        """Distances (n,) in pixels of points ``xy`` (n, 2) from the flat page that fits them best.

        ``index`` (n, 2): their columns and rows.
        """
        centre, spread = index.mean(axis=0), max(index.std(), 1e-9)
        plane = np.column_stack([(index - centre) / spread, np.ones(len(index))])
        a, b = self.plane(*xy.T)
        nothing = np.zeros_like(plane)
        system = np.vstack([np.hstack([plane, nothing, -a[:, None] * plane]),
                            np.hstack([nothing, plane, -b[:, None] * plane])])
        start = np.linalg.svd(system, full_matrices=False)[2][-1]

        def off(matrix):
            rays = plane @ matrix.reshape(3, 3).T
            return (self.pixels(rays * np.sign(np.median(rays[:, 2]))) - xy).ravel()
        best = least_squares(off, start / np.linalg.norm(start), x_scale="jac").x
        return np.linalg.norm(off(best).reshape(-1, 2), axis=1)


class Plane:
    """The page of a rendered target whose columns and rows are ``extent``, at a pose as of
    :class:`ncdc_bench.photos.targets.Pose`: flat, or bent round a cylinder."""

    def __init__(self, pose, extent):
        turn = rotation(*np.radians([*pose.tilts, -pose.turn]))
        self.axes, self.bend, self.sheets = pose.step * turn, pose.bend, pose.sheets
        self.middle = (np.array(extent) - 1) / 2
        self.origin = np.array([*pose.middle, 1.0])

    def rays(self, index):
        """Directions (n, 3) to the points ``index`` (n, 2)."""
        if self.sheets:
            index = index + (self._beyond(*index.T) > 0)[:, None] * self.sheets[2]
        across, down = (index - self.middle).T
        deep = np.zeros_like(across)
        if self.bend:
            angle = across * self.bend
            across, deep = np.sin(angle) / self.bend, (1 - np.cos(angle)) / self.bend
        return self.origin + np.stack([across, down, deep], axis=1) @ self.axes.T

    def cells(self, a, b):
        """Column and row of the page, arrays, that is seen in the directions (``a``, ``b``, 1);
        not-a-number outside it."""
        back = np.linalg.inv(self.axes)
        u, v, w = (part[0] * a + part[1] * b + part[2] for part in back.astype(np.float32))
        p, q, r = (back @ self.origin).astype(np.float32)
        with np.errstate(all="ignore"):
            far = r / w
            if self.bend:
                # On the cylinder x^2 + z^2 = 2 z / bend, the meeting nearer to the flat page's.
                k = self.bend
                first, second = k * (u * u + w * w), -2 * (k * (u * p + w * r) + w)
                third = k * (p * p + r * r) + 2 * r
                root = np.sqrt(second * second - 4 * first * third)
                far = 2 * third / (-second + np.where(second < 0, root, -root))
            across, down, deep = far * u - p, far * v - q, far * w - r
            if self.bend:
                across = np.arctan2(self.bend * across, 1 - self.bend * deep) / self.bend
        inside = (far > 0) & np.isfinite(across)
        cells = [np.where(inside, part + middle, np.nan)
                 for part, middle in zip((across, down), self.middle)]
        if self.sheets:
            beyond = self._beyond(*cells) > 0
            cells = [np.where(beyond, part - shift, part)
                     for part, shift in zip(cells, self.sheets[2])]
        return cells

    def whole(self, index):
        """Which points (n,) no seam cuts."""
        if not self.sheets:
            return np.ones(len(index), bool)
        return np.abs(self._beyond(*index.T)) > _CUT

    def _beyond(self, columns, rows):
        """Steps from the seam, which lies a little askew, to each point."""
        axis, line, _ = self.sheets
        along = (rows, columns)[axis] - self.middle[1 - axis]
        return (columns, rows)[axis] - line - 0.5 + _ASKEW * along
