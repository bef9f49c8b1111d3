"""Estimates the error of a map over its whole valid region from points of a target.

Held-out points lie among the others. They do not measure the map between the outermost points and
the border of the picture, nor do they find the largest error. So the true map is estimated
everywhere: it is the :mod:`~ncdc_model.training.free_lens` plus a Gaussian process regression
("kriging") of its residuals at the points. What both leave open counts as error: beyond the
outermost points mostly the form of the lens.
"""

from dataclasses import dataclass

import cv2
import numpy as np

from ncdc_model.mask_border import border_pixels
from ncdc_model.nearest import Nearest
from ncdc_model.training.free_lens import free_lens
from ncdc_model.training.problem import spread
from ncdc_spec.errors import InputError

__all__ = ["Region", "region_of"]

_STEP = 144            # parts of the longer side: distance of the compared pixels
_BORDER = 4000         # compared pixels along the border of the region, where errors are largest
_SOME = 600            # points for choosing the scales of the regression
_NEAR = 32             # nearest points in each regression
_BATCH = 64            # regressions at a time: their matrices stay in the cache
_LENGTHS = 2.0 ** np.arange(-1, 6)      # scales of the residual, in typical distances of points
_NOISES = 4.0 ** np.arange(-7, 4)       # variance of the points over that of the residual
_NOTHING = 1e-8        # variance over the noise of a process that is none
_SIGMAS = 3.0          # standard deviations of the estimate that the largest error includes
_UNSURE, _UNSURE_PIXELS = 1 / 1280, 0.5     # of the width, and at least: is warned of
_MOST = 0.5, 0.75      # of the pixels beyond the points: is named as the side, or as both sides
_LEFT = 0.05           # of the frame, which a limit of the uncertainty must leave
_LARGE = 4096          # positions at a time: bounds the memory
_BETWEEN = 1.05        # times the largest error: allowance for peaks between the compared pixels


@dataclass(frozen=True)
class Region:
    """Estimated sources of pixels across the valid region.

    Parameters
    ----------
    u, v : ndarray, shape (n,)
        Corrected pixels, whole numbers.
    x, y : ndarray, shape (n,)
        Their sources in distorted pixels.
    sigma : ndarray, shape (n,)
        Standard deviation of x, and of y.
    beyond : ndarray of bool, shape (n,)
        Whether a pixel lies beyond the outermost points.
    border : ndarray of bool, shape (n,)
        Pixels on the border, which are denser than the others and count for the largest error only.
    taught : ndarray, shape (n, 2)
        The sources by the smooth lens, which a network follows beyond the points.
    certain : ndarray of bool, shape (height, width), or None
        Corrected pixels that are known as well as was asked for; None if nothing was.
    """
    u: np.ndarray
    v: np.ndarray
    x: np.ndarray
    y: np.ndarray
    sigma: np.ndarray
    beyond: np.ndarray
    border: np.ndarray
    taught: np.ndarray
    certain: np.ndarray | None = None

    @property
    def beyond_part(self):
        """Part of the region that lies beyond the outermost points."""
        return float(self.beyond[~self.border].mean()) if (~self.border).any() else 0.0

    @property
    def uncertain(self):
        """Pixels by which a map that follows the smooth lens may be off beyond the outermost
        points, at worst."""
        off = np.hypot(*(self.taught - np.stack([self.x, self.y], axis=1)).T)
        return float((off + _SIGMAS * self.sigma)[self.beyond].max(initial=0))

    def warning(self, width):
        """A sentence on the error beyond the points of photos of so many columns; empty if it is
        known well."""
        if self.uncertain <= max(_UNSURE * width, _UNSURE_PIXELS):
            return ""
        return (f"{100 * self.beyond_part:.0f} % of the picture lies beyond the outermost points, "
                f"{self._side()}; its error is not known better than "
                f"{float(f'{self.uncertain:.2g}'):g} px. Points nearer to the border determine it; "
                f"--blank-beyond PX leaves out what is less certain than PX")

    def _side(self):
        """Where the pixels beyond the points are, in words."""
        here = self.beyond & ~self.border if (self.beyond & ~self.border).any() else self.beyond
        x, y = ((values[here], values[~self.beyond]) for values in (self.x, self.y))
        if not len(x[1]):
            return "all of it"
        over = [x[1].min() - x[0], x[0] - x[1].max(), y[1].min() - y[0], y[0] - y[1].max()]
        share = np.bincount(np.argmax(over, axis=0), minlength=4) / here.sum()
        first, second = np.argsort(-share, kind="stable")[:2]
        names = "on the left", "on the right", "at the top", "at the bottom"
        if share[first] > _MOST[0]:
            return f"most of it {names[first]}"
        if share[first] + share[second] > _MOST[1]:
            first, second = sorted((first, second))
            return f"most of it {names[first]} and {names[second]}"
        return "on all sides"

    def learnt(self, back_map):
        """The largest error, in pixels, of what a network can learn.

        Among the points that is the map, with what they leave open. Beyond the points it is the
        smooth lens: that this may be wrong does not depend on the network.
        """
        goal = np.where(self.beyond[:, None], self.taught, np.stack([self.x, self.y], axis=1))
        off = np.linalg.norm(np.stack(back_map(self.u, self.v), axis=1) - goal, axis=1)
        return float((_BETWEEN * off + np.where(self.beyond, 0, _SIGMAS * self.sigma)).max())

    def bound(self, back_map, valid):
        """The largest error of a map at the pixels ``valid`` (height, width), each as that of the
        nearest compared pixel: (height, width), not-a-number elsewhere."""
        off = np.hypot(*np.subtract(back_map(self.u, self.v), (self.x, self.y)))
        step, even = _step(valid.shape), ~self.border
        picture = np.full(tuple(-(-side // step) for side in valid.shape), np.nan)
        picture[self.v[even] // step, self.u[even] // step] = (off + _SIGMAS * self.sigma)[even]
        whole = np.repeat(np.repeat(picture, step, axis=0), step, axis=1)
        return np.where(valid, whole[:valid.shape[0], :valid.shape[1]], np.nan)

    def errors(self, back_map, smooth_map=None):
        """Error of ``back_map``, (u, v) -> (x, y), in the region, and beyond the points alone.

        ``smooth_map`` may be nearly the same without rounding, for the derivatives alone.

        The result is two dicts of ``mse``, ``mean`` and ``max`` as of
        :func:`ncdc_model.evaluate.map_error`. ``mse`` is the expected square of the error. ``max``
        is the largest error, either in this corrected picture or after removing the best
        homography. It includes three standard deviations of its estimate, and 5 % for peaks
        between the compared pixels. The second dict is not-a-number if no pixel is beyond the
        points.
        """
        off = np.stack(back_map(self.u, self.v), axis=1) - np.stack([self.x, self.y], axis=1)
        square = (off**2).sum(axis=1) + 2 * self.sigma**2
        worst = _SIGMAS * self.sigma + _BETWEEN * np.maximum(
            np.hypot(*off.T), np.hypot(*self._without_view(smooth_map or back_map, off).T))
        result = []
        for which in (np.ones(len(off), bool), self.beyond):
            even = which & ~self.border if (which & ~self.border).any() else which
            result.append({
                "mse": float(square[even].mean()), "mean": float(np.sqrt(square[even]).mean()),
                "max": float(worst[which].max())} if which.any() else
                dict.fromkeys(("mse", "mean", "max"), float("nan")))
        return tuple(result)

    def _without_view(self, smooth_map, off):
        """``off`` (n, 2) minus the part that a small homography of the picture explains."""
        u, v = self.u.astype(np.float64), self.v.astype(np.float64)
        along_u, along_v = (np.stack(smooth_map(u + du, v + dv), axis=1)
                            - np.stack(smooth_map(u - du, v - dv), axis=1)
                            for du, dv in ((.5, 0), (0, .5)))
        a, b = ((values - values.mean()) / max(values.std(), 1.0) for values in (u, v))
        one, nothing = np.ones_like(a), np.zeros_like(a)
        moves = [(one, nothing), (a, nothing), (b, nothing), (nothing, one), (nothing, a),
                 (nothing, b), (a * a, a * b), (a * b, b * b)]
        terms = np.stack([du[:, None] * along_u + dv[:, None] * along_v for du, dv in moves],
                         axis=2)
        even = ~self.border if (~self.border).sum() > len(moves) else np.ones(len(u), bool)
        solution = np.linalg.lstsq(terms[even].reshape(-1, len(moves)), off[even].ravel(),
                                   rcond=1e-9)[0]
        return off - terms @ solution


class _Estimate:
    """The true map as the points of ``frame`` show it, up to the view angle ``largest``."""

    def __init__(self, frame, largest):
        self._frame, self._lens = frame, free_lens(frame, largest)
        seen, points = self._lens.seen, frame.distorted
        usable = np.abs(points - seen).max(axis=1) < max(frame.camera.size)
        self.points = points[usable]
        self._rest = _Regression(seen[usable], self.points - seen[usable])

    def __call__(self, u, v):
        """Sources (n, 2) of corrected pixels, and the standard deviation (n,) of x and of y."""
        at, deviation = np.empty((len(u), 2)), np.empty(len(u))
        for start in range(0, len(u), _LARGE):
            part = slice(start, start + _LARGE)
            a, b = self._frame.camera.frame.ideal(u[part], v[part])
            seen = self._lens.pixels(a, b)
            mean, deviation[part] = self._rest(seen)
            at[part] = seen + mean
            deviation[part] = np.hypot(deviation[part], self._lens.deviation(a, b))
        return at, deviation

    def beyond(self, at):
        """Whether sources (n, 2) lie beyond the outermost points."""
        return ~_inside(self.points, at)

    def certain(self, size, limit):
        """Corrected pixels (height, width) that are known to ``limit`` pixels, where a map learns
        the points, and beyond them follows the smooth lens."""
        (width, height), step = size, _step(size)
        rows, columns = (np.arange(-(-side // step)) * step + (step - 1) / 2
                         for side in (height, width))
        v, u = (values.ravel() for values in np.meshgrid(rows, columns, indexing="ij"))
        at, deviation = self(u, v)
        off = np.hypot(*(at - np.stack(self._frame.camera.back_map(u, v), axis=1)).T)
        doubt = np.nan_to_num(_SIGMAS * deviation + off * self.beyond(at), nan=np.inf)
        coarse = np.minimum(doubt / limit, 2).reshape(len(rows), len(columns))
        return cv2.resize(coarse, None, fx=step, fy=step,
                          interpolation=cv2.INTER_LINEAR)[:height, :width] <= 1


def region_of(frame, inside, limit=None):
    """:class:`Region` of the corrected picture of an :class:`IdealFrame`.

    Parameters
    ----------
    frame : ncdc_model.calibration.frame.IdealFrame
    inside : ndarray of bool, shape (height, width)
        Corrected pixels with a source by the smooth lens of ``frame``.
    limit : float, optional
        Pixels: the region leaves out what is less certain.

    Raises
    ------
    InputError
        If ``limit`` leaves less than a twentieth of the picture.
    """
    u, v, border = _pixels(inside)
    a, b = frame.camera.frame.ideal(u, v)
    estimate, certain = _Estimate(frame, float(np.arctan(np.hypot(a, b).max()))), None
    if limit is not None:
        certain = estimate.certain(inside.shape[::-1], limit)
        left = float((inside & certain).mean())
        if left < _LEFT:
            raise InputError(f"{100 * left:.1f} % of the corrected frame is known to {limit:g} px "
                             f"or better, {100 * _LEFT:.0f} % is the limit: blank beyond more")
        u, v, border = _pixels(inside & certain)
    at, sigma = estimate(u, v)
    return Region(u, v, *at.T, sigma, estimate.beyond(at), border,
                  np.stack(frame.camera.back_map(u, v), axis=1), certain)


def _step(size):
    """Distance of the compared pixels."""
    return max(1, round(max(size) / _STEP))


def _pixels(valid):
    """Columns and rows of a grid of ``valid`` pixels and of their border, and which are these."""
    step = _step(valid.shape)
    rows, columns = border_pixels(valid, _BORDER)
    start = step // 2
    rows_even, columns_even = np.nonzero(valid[start::step, start::step])
    even = columns_even * step + start, rows_even * step + start
    border = np.arange(len(even[0]) + len(rows)) >= len(even[0])
    return np.concatenate([even[0], columns]), np.concatenate([even[1], rows]), border


class _Regression:
    """A Gaussian process through ``rest`` (n, 2) at ``known`` (n, 2)."""

    def __init__(self, known, rest):
        self._known, self._rest, self._nearest = known, rest, Nearest(known)
        self._length, self._noise, self._variance = _scales(known, rest)

    def __call__(self, at):
        """Mean (m, 2) and standard deviation (m,) at ``at`` (m, 2), from the nearest points of each
        position."""
        count = min(_NEAR, len(self._known))
        distance, near = self._nearest.query(at, count)
        mean, sigma = np.empty_like(at), np.empty(len(at))
        for start in range(0, len(at), _BATCH):
            block = slice(start, start + _BATCH)
            x, y = self._known[near[block]].transpose(2, 0, 1)
            among = np.sqrt((x[:, :, None] - x[:, None])**2 + (y[:, :, None] - y[:, None])**2)
            matrix = _covariance(among, self._length) + self._noise * np.eye(count)
            to = _covariance(distance[block], self._length)
            weight = np.linalg.solve(matrix, to[:, :, None])[:, :, 0]
            mean[block] = np.einsum("nk,nkd->nd", weight, self._rest[near[block]])
            sigma[block] = np.sqrt(np.maximum(
                self._variance * (1 - (weight * to).sum(axis=1)), 0))
        return mean, sigma


def _covariance(distance, length):
    """Matérn covariance of order 5/2, divided by the variance."""
    far = np.sqrt(5) * distance / length
    return (1 + far + far * far / 3) * np.exp(-far)


def _scales(known, rest):
    """Length in pixels, noise over variance, and variance, of maximum likelihood.

    Where no process explains ``rest`` better than noise alone, by more than its two parameters are
    worth (Schwarz's criterion), there is none.
    """
    some = spread(len(known), _SOME)
    known, rest = known[some], rest[some]
    distance = np.linalg.norm(known[:, None] - known, axis=2)
    pitch = float(np.median(np.sort(distance, axis=1)[:, min(1, len(known) - 1)]))
    alone = max(float((rest**2).mean()), 1e-18)
    count = 2 * len(known)
    best = (count * np.log(alone) - 2 * np.log(count), max(pitch, 1.0), 1 / _NOTHING,
            alone * _NOTHING)
    for length in _LENGTHS * max(pitch, 1.0):
        values, vectors = np.linalg.eigh(_covariance(distance, length))
        turned = ((vectors.T @ rest)**2).sum(axis=1)
        for noise in _NOISES:
            spectrum = np.maximum(values, 0) + noise
            variance = float((turned / spectrum).mean() / 2)
            cost = count * np.log(max(variance, 1e-18)) + 2 * np.log(spectrum).sum()
            if cost < best[0]:
                best = cost, length, noise, variance
    return best[1:]


def _inside(points, at):
    """Whether the positions ``at`` (m, 2) lie in the convex hull of ``points`` (n, 2)."""
    corners = points[cv2.convexHull(points.astype(np.float32), returnPoints=False)[:, 0]]
    within = np.full((2, len(at)), len(corners) > 2)        # of either sense of rotation
    for first, second in zip(corners, np.roll(corners, -1, axis=0)):
        dx, dy = second - first
        side = dx * (at[:, 1] - first[1]) - dy * (at[:, 0] - first[0])
        within &= np.stack([side >= 0, side <= 0])
    return within.any(axis=0)
