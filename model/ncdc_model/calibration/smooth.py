"""Fits one smooth lens and a pose of the target per photo to the points."""

from dataclasses import dataclass

import numpy as np

from ncdc_model.calibration.refine import refine
from ncdc_model.calibration.smooth_errors import Estimate, shown
from ncdc_model.calibration.smooth_problem import MIN_POINTS, ROBUST, Problem
from ncdc_model.calibration.smooth_vector import FLAWS, camera_of, planes_of, project
from ncdc_model.lens import Camera
from ncdc_spec.errors import InputError

__all__ = ["MIN_POINTS", "SmoothFit", "fit_smooth", "misfit"]


_ROUGH = 0.1           # pixels: usual residual that a rough fit may leave


@dataclass(frozen=True)
class SmoothFit:
    """A smooth camera and, per photo, the target's plane seen by it.

    Parameters
    ----------
    camera : Camera
        Radial (equidistant with polynomial), decentring, thin prism, tilted sensor, pixels that
        are not square; its frame is the image.
    planes : tuple of ndarray, shape (3, 3)
        Take (column, row, 1) of a photo's target to a direction in camera coordinates.
    vector : ndarray
        The parameters that were fitted.
    prior : float
        Weight of the prior of the lens, up to 1.
    flaws : tuple of str
        Those of :data:`~ncdc_model.calibration.smooth_vector.FLAWS` that the points show. The
        others are zero.
    """
    camera: Camera
    planes: tuple
    vector: np.ndarray
    prior: float
    flaws: tuple

    @classmethod
    def of(cls, size, fit):
        """The lens of a :class:`~ncdc_model.calibration.points.Fit` for photos of a ``size``."""
        return cls(camera_of(fit.vector, size), tuple(planes_of(fit.vector)), fit.vector, fit.prior,
                   fit.flaws)

    def rays(self, photo, index):
        """Directions (n, 3) of the target's points ``index`` (n, 2) in photo number ``photo``."""
        return index @ self.planes[photo][:, :2].T + self.planes[photo][:, 2]

    def normal(self, photo, index):
        """Pixels (n, 2) by which points of the target move for a step, one column, towards the
        camera along its normal."""
        return (self.raised(photo, index, 0.01) - self.raised(photo, index, -0.01)) / 0.02

    def raised(self, photo, index, height):
        """Pixels (n, 2) by which points of the target move that lie ``height``, a number or (n,),
        steps above its plane, towards the camera."""
        first, second, _ = self.planes[photo].T
        up = np.cross(second, first) * np.linalg.norm(first)
        up = up / np.linalg.norm(np.cross(first, second))
        rays = self.rays(photo, index)
        return self._seen(rays + np.multiply.outer(height, up)) - self._seen(rays)

    def pixels(self, photo, index):
        """Distorted pixels (n, 2) of the target's points ``index`` (n, 2)."""
        return self._seen(self.rays(photo, index))

    def _seen(self, rays):
        return np.stack(project(self.camera, *rays.T), axis=1)


def fit_smooth(size, photos, near=None, rough=False):
    """Robust least squares of the distance between points and their projections, in pixels.

    The target is flat with equal distances along columns and rows up to a common ratio, which
    is fitted too. So the pose explains a tilt of the page, which does not distort the
    lens. The lens: equidistant with a polynomial of four terms, free centre and focal length,
    decentring (equation (14) of the paper), thin prism of first order (Weng's), a tilted sensor
    and the aspect of its pixels. A prior decides what the points do not determine.

    Parameters
    ----------
    size : (int, int)
        Width and height of the photos.
    photos : sequence of (index, xy)
        Arrays (n, 2) of each photo.
    near : SmoothFit, optional
        A fit of nearly the same points: the search starts there.
    rough : bool
        Fit only some of the points; the last digits may differ from machine to machine.

    Returns
    -------
    SmoothFit

    Raises
    ------
    InputError
        If a photo has fewer than 12 points or no lens explains the points.
    """
    for index, xy in photos:
        if len(index) < MIN_POINTS:
            raise InputError(f"a photo has {len(index)} points, at least {MIN_POINTS} are needed")
        if np.ptp(xy, axis=0).max() < 1:
            raise InputError("no smooth lens explains the points: all of a photo are within one "
                             "pixel")
    problem = Problem(size, photos)
    start, prior, flaws = _started(problem, near, _ROUGH if rough else 0.0)
    vector = start if rough else refine(
        lambda vector: problem.residuals(vector, prior),
        lambda vector: problem.derivatives(vector, prior, flaws), start, ROBUST)
    typical = np.median(np.abs(problem.residuals(vector, prior)))
    if not typical < 0.02 * max(size):
        raise InputError(f"no smooth lens explains the points: half of them are off by more than "
                         f"{typical:.1f} pixels")
    return SmoothFit(camera_of(vector, size), tuple(planes_of(vector)), vector, prior, flaws)


def _started(problem, near, enough):
    """Vector close to that of the best fit, weight of the prior, and the flaws that the points
    show; arguments as of :func:`fit_smooth` and :meth:`Problem.searched`."""
    part = problem.part()
    if near is None:
        vector, prior, flaws = part.searched(enough)
    else:
        prior, flaws = near.prior, tuple(FLAWS)
        vector, _ = part.solved(near.vector, prior, flaws)
    if enough or not flaws:
        return vector, prior, flaws
    flaws = shown(Estimate.of(problem, vector), vector)
    if flaws == tuple(FLAWS):
        return vector, prior, flaws
    return part.solved(vector, prior, flaws)[0], prior, flaws


def misfit(size, photos):
    """Median distance, in pixels, of points from the smooth lens fitted to them; inf if none fits.

    Arguments as of :func:`fit_smooth`.
    """
    try:
        fit = fit_smooth(size, photos, rough=True)
    except InputError:
        return np.inf
    return float(np.median(np.concatenate([
        np.linalg.norm(fit.pixels(k, index) - xy, axis=1)
        for k, (index, xy) in enumerate(photos)])))
