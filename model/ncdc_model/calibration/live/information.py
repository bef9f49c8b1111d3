"""What photos determine of a lens: the uncertainty of its map, and how much a pose would reduce it.

The points of a photo in a pose have the derivatives L by the lens and P by the pose, in pixels.
Without the pose, which is unknown, they contribute

    A = (L^T L - L^T P (P^T P)^-1 P^T L) / sigma^2

to the information about the lens: sigma is the usual distance of a point from the fitted lens on
one axis. With the prior S^-2 of usual lenses, the covariance of the lens is

    C = (S^-2 + sum of A over the photos)^-1.

G holds the derivatives by the lens of n positions in the picture, without what a plane
perspective view explains: such a part changes the view of the corrected picture and bends no line.
The uncertainty is u = sqrt(trace(G C G^T) / n), pixels rms. A further pose adds its own A, and its
gain is 1 - u' / u.
"""

import numpy as np

from ncdc_model.calibration.smooth_problem import SPREAD
from ncdc_model.calibration.smooth_vector import LENS, fixed, lens_of, project

__all__ = ["Information"]

_FREE = np.setdiff1d(np.arange(LENS - 1), fixed(()))     # the last: the ratio of distances
_GRID = 16, 12          # positions in the picture where the map is judged
_PROBE = 1e-3           # of a parameter's usual deviation: step of a derivative
_TURN = 1e-5            # of a direction: step of a derivative
_MIN_SIGMA = 0.02       # pixels: rounding and noise leave as much


class Information:
    """Information about the lens of a :class:`SmoothFit` to ``photos``, pairs (index, xy).

    Attributes
    ----------
    sigma : float
        Usual distance of a point from the fitted lens on one axis, in pixels.
    uncertainty : float
        u of this module, pixels rms.
    """

    def __init__(self, fit, photos):
        self.fit, self.camera = fit, fit.camera
        off = np.concatenate([fit.pixels(k, index) - xy for k, (index, xy) in enumerate(photos)])
        self.sigma = max(_MIN_SIGMA, 1.4826 * float(np.median(np.abs(off))))
        width = self.camera.size[0]
        units = np.array([self.camera.focal, width, width] + [1.0] * (LENS - 3))
        self._usual = (units * SPREAD)[[*_FREE, LENS - 1]]
        self._matrix = np.diag(self._usual**-2.0) + sum(
            self.part(plane, index) for plane, (index, _) in zip(fit.planes, photos))
        self._map = self._map_derivatives()
        self.uncertainty = self._uncertainty(self._matrix)

    def part(self, plane, index):
        """A of this module for the points ``index`` (n, 2) of a target in the pose ``plane``."""
        rays = index @ plane[:, :2].T + plane[:, 2]
        by_ray = _by_ray(self.camera, rays)
        ratio = np.einsum("nij,nj->ni", by_ray, index[:, 1:] * plane[:, 1])
        lens = np.concatenate([self._by_lens(rays), ratio[..., None]], axis=-1)
        lens = lens.reshape(-1, lens.shape[-1])
        cross = np.zeros((len(rays), 3, 3))
        x, y, z = rays.T
        cross[:, 0, 1], cross[:, 0, 2], cross[:, 1, 2] = z, -y, x
        cross -= cross.swapaxes(1, 2)
        pose = (by_ray @ np.concatenate([cross, np.broadcast_to(np.eye(3), cross.shape)],
                                        axis=-1)).reshape(-1, 6)
        known = np.linalg.lstsq(pose, lens, rcond=1e-9)[0]
        return lens.T @ (lens - pose @ known) / self.sigma**2

    def gain(self, plane, index):
        """Part, 0 to 1, by which the pose ``plane`` of the points ``index`` would reduce the
        uncertainty."""
        return 1 - self._uncertainty(self._matrix + self.part(plane, index)) / self.uncertainty

    def _uncertainty(self, matrix):
        root = np.linalg.cholesky((matrix + matrix.T) / 2 * np.outer(self._usual, self._usual))
        spread = np.linalg.solve(root, (self._map * self._usual).T)
        return float(np.sqrt(2 * (spread**2).sum() / self._map.shape[0]))

    def _by_lens(self, rays):
        """Derivatives (n, 2, free) of the pixels of ``rays`` (n, 3) by the lens."""
        step = _PROBE * self._usual[:-1]
        moves = np.zeros((len(_FREE), LENS))
        moves[np.arange(len(_FREE)), _FREE] = step
        start = self.fit.vector[:LENS]
        ends = [np.stack([np.stack(project(lens_of(start + sign * move), *rays.T), axis=-1)
                          for move in moves]) for sign in (1, -1)]
        return np.moveaxis((ends[0] - ends[1]) / (2 * step[:, None, None]), 0, -1)

    def _map_derivatives(self):
        """G of this module, (2 n, free + 1); the target's ratio changes no map."""
        (width, height), (columns, rows) = self.camera.size, _GRID
        x, y = np.meshgrid((np.arange(columns) + .5) * width / columns - .5,
                           (np.arange(rows) + .5) * height / rows - .5)
        rays = self.camera.ray(x.ravel(), y.ravel())
        rays = rays[np.isfinite(rays).all(axis=1)]
        lens = self._by_lens(rays).reshape(2 * len(rays), -1)
        views = np.einsum("nij,nk->nijk", _by_ray(self.camera, rays), rays)
        basis, size, _ = np.linalg.svd(views.reshape(2 * len(rays), 9), full_matrices=False)
        basis = basis[:, size > 1e-9 * size[0]]
        lens -= basis @ (basis.T @ lens)
        return np.column_stack([lens, np.zeros(len(lens))])


def _by_ray(camera, rays):
    """Derivatives (n, 2, 3) of the pixels of directions ``rays`` (n, 3) by these."""
    step = _TURN * np.linalg.norm(rays, axis=1)
    return np.stack([
        (np.stack(project(camera, *(rays + step[:, None] * axis).T), axis=1)
         - np.stack(project(camera, *(rays - step[:, None] * axis).T), axis=1))
        / (2 * step[:, None]) for axis in np.eye(3)], axis=-1)
