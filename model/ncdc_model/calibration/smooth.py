"""One smooth lens and a pose of the target per photo, fitted together to the points."""

from dataclasses import dataclass
from functools import lru_cache
from types import SimpleNamespace

import numpy as np
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from ncdc_model.calibration.settle import settle
from ncdc_model.errors import InputError
from ncdc_model.lens import AsymmetricSurface, BrownWeng, Camera, Frame, KannalaBrandt, TiltedSensor

__all__ = ["MIN_POINTS", "SmoothFit", "fit_smooth", "misfit"]

MIN_POINTS = 12        # of a photo: its pose has six unknowns, the lens has nine more
_FOCALS = (0.3, 0.45, 0.7, 1.1)     # first guesses, in image widths
_ROBUST = 0.5          # pixels: residuals beyond count linearly
_TERMS = 4             # of the radial polynomial
# The lens's parameters: focal length, centre, k, p and its higher terms, s0 and s2, tilt of the
# sensor, aspect of its pixels, and the ratio of the target's distances.
_LENS = 3 + _TERMS + 4 + 2 + 2 + 1 + 1

# One photo cannot tell an asymmetric lens from a tilted page, nor a long lens near the page from a
# short one far away: what is usual of a lens decides. Mean and standard deviation of the focal
# length (its logarithm, in widths), the centre (from the middle, in widths) and the others in the
# order above. Photos from several sides do tell; then the usual counts for little.
_MEAN = np.array([np.log(0.5)] + [0.0] * (_LENS - 1))
_SPREAD = np.array([0.4] + [0.03] * 2 + [0.15] * _TERMS + [0.002] * 2 + [0.5] * 2 + [0.002] * 2
                   + [0.02] * 2 + [0.02, 0.01])
_ALONE, _TOGETHER = 1 / 128, 1 / 1280     # of the width: what one deviation weighs in a residual
# Of the width: what a lens that is not smooth leaves. Where less is left the points tell the lens,
# and the usual weighs less in proportion, down to its least part. Nothing but the usual tells the
# higher terms of a decentring that is hardly there.
_LEFT = 1 / 2000
_MOST = 0.15, 0.10     # by which the pixels' aspect and the target's ratio may differ from 1
_LEAST = np.array([0.01] * (5 + _TERMS) + [0.1] * 2 + [0.01] * 6)
# Pixels that are no squares, a tilted sensor and higher terms of a decentring are believed only
# where they explain most of what is left: else they are taken up by a bent page, or an uneven lens.
_FLAW = np.isin(np.arange(_LENS), [5 + _TERMS, 6 + _TERMS, *range(9 + _TERMS, 12 + _TERMS)])
_EXPLAINS = 1.0, 0.4   # of what is left without them
_SETTLED = 0.8         # of what the usual weighed: if less is due the fit is made again
_BLOCK = 1 << 15       # numbers that are worked on at a time
_PROBE = 1e-6          # of a parameter: by which it is moved for a derivative
_SOME = 600            # points of all photos that a search is made on
_ROUNDS = 6            # of fits, each weighing the usual by what the one before has left


@dataclass(frozen=True)
class SmoothFit:
    """A smooth camera and, per photo, the target's plane seen by it.

    Parameters
    ----------
    camera : Camera
        Radial (equidistant with polynomial), decentring, thin prism, tilted sensor and pixels that
        are no squares; frame as the image.
    planes : tuple of ndarray, shape (3, 3)
        Take (column, row, 1) of a photo's target to a direction in camera coordinates.
    vector : ndarray
        The parameters that were fitted.
    doubt : float
        How much what is usual of a lens counts, up to 1.
    flawed : bool
        Whether the camera has the flaws that only a lens well explained may have.
    """
    camera: Camera
    planes: tuple
    vector: np.ndarray
    doubt: float
    flawed: bool

    def rays(self, photo, index):
        """Directions (n, 3) of the target's points ``index`` (n, 2) in photo number ``photo``."""
        return index @ self.planes[photo][:, :2].T + self.planes[photo][:, 2]

    def normal(self, photo, index):
        """Pixels (n, 2) by which points of the target move for a step, one column, towards the
        camera along its normal."""
        first, second, _ = self.planes[photo].T
        step = 0.01 * np.cross(first, second) * np.linalg.norm(first)
        step = step / np.linalg.norm(np.cross(first, second))
        rays = self.rays(photo, index)
        return (self._seen(rays - step) - self._seen(rays + step)) / 0.02

    def pixels(self, photo, index):
        """Distorted pixels (n, 2) of the target's points ``index`` (n, 2)."""
        return self._seen(self.rays(photo, index))

    def _seen(self, rays):
        return np.stack(_project(self.camera, *rays.T), axis=1)


def fit_smooth(size, photos, near=None, rough=False):
    """Robust least squares of the distance between points and their projections, in pixels.

    The target is flat with equal distances along columns and rows up to a common ratio, which
    is fitted too. So a tilt of the page is explained by its pose and does not end up in the
    lens. The lens: equidistant with a polynomial of four terms, free centre and focal length,
    decentring (equation (14) of the paper), thin prism of first order (Weng's), a tilted sensor
    and the aspect of its pixels. What is usual of a lens counts as much as the points leave open.

    Parameters
    ----------
    size : (int, int)
        Width and height of the photos.
    photos : sequence of (index, xy)
        Arrays (n, 2) of each photo.
    near : SmoothFit, optional
        Of nearly the same points: the search starts there.
    rough : bool
        Whether a fit of some of the points will do, which may differ in its last digits.

    Returns
    -------
    SmoothFit

    Raises
    ------
    InputError
        If a photo has fewer than 12 points or no lens explains the points.
    """
    for index, _ in photos:
        if len(index) < MIN_POINTS:
            raise InputError(f"a photo has {len(index)} points, at least {MIN_POINTS} are needed")
    problem = _Problem(size, photos)
    start, doubt, flawed = ((near.vector, near.doubt, near.flawed) if near else
                            problem.part().searched())
    vector = start if rough else settle(
        lambda vector: problem.residuals(vector, doubt),
        lambda vector, steps: problem.derivatives(vector, steps, doubt, flawed), start,
        _ROBUST)
    typical = np.median(np.abs(problem.residuals(vector, doubt)))
    if not typical < 0.02 * max(size):
        raise InputError(f"no smooth lens explains the points: half of them are off by more than "
                         f"{typical:.1f} pixels")
    return SmoothFit(_camera(vector, size), tuple(_unpack(vector)[1]), vector, doubt, flawed)


class _Problem:
    """Points of photos, and how far a vector of parameters is from them."""

    def __init__(self, size, photos):
        self.size = size
        self.indices = [np.asarray(index, np.float64) for index, _ in photos]
        self.points = [np.asarray(xy, np.float64) for _, xy in photos]
        self.measured = np.concatenate(self.points)
        self.cells = np.concatenate(self.indices)
        self.owner = np.repeat(np.arange(len(photos)), [len(xy) for xy in self.points])
        self.usual = size[0] * max(_ALONE / len(photos)**2, _TOGETHER) / _SPREAD

    def part(self):
        """The problem of some of each photo's points: a search needs no more."""
        most, rng = max(_SOME // len(self.points), MIN_POINTS), np.random.default_rng(1)
        chosen = [rng.permutation(len(xy))[:most] for xy in self.points]
        return _Problem(self.size, [(index[some], xy[some]) for index, xy, some in
                                    zip(self.indices, self.points, chosen)])

    def errors(self, vectors):
        """Pixels (..., 2 n) from each point to its projection, of vectors (..., m)."""
        lens, planes = _unpack(vectors)
        i, j = self.cells.T
        rays = (planes[..., self.owner, axis, 0] * i + planes[..., self.owner, axis, 1] * j
                + planes[..., self.owner, axis, 2] for axis in range(3))
        off = np.stack(_project(lens, *rays), axis=-1) - self.measured
        return np.nan_to_num(off.reshape(*off.shape[:-2], -1), nan=1e4)

    def residuals(self, vectors, doubt=1.0):
        """The errors, and ``doubt`` times how unusual the lens is, of vectors (..., m)."""
        lens = vectors[..., :_LENS].copy()
        lens[..., 0] = np.log(np.maximum(lens[..., 0], 1.0) / self.size[0])
        lens[..., 1:3] = (lens[..., 1:3] - (np.array(self.size) - 1) / 2) / self.size[0]
        unusual = np.maximum(doubt, _LEAST) * self.usual * (lens - _MEAN)
        return np.concatenate([self.errors(vectors), unusual], axis=-1)

    def derivatives(self, vector, steps, doubt=1.0, flawed=True):
        """Of the residuals by each parameter, moved by its of ``steps`` to either side: a row each,
        of zeros for the flaws of a camera that is not ``flawed``.

        A photo's pose moves its own points only, so that those of all photos are moved together.
        """
        points, poses = 2 * len(self.owner), _LENS + np.arange(6)
        probes = [*np.flatnonzero(~_FLAW | flawed), *poses]
        moves = np.zeros((len(probes), len(vector)))
        for move, number in zip(moves, probes):
            which = slice(number, None, 6) if number >= _LENS else number
            move[which] = steps[which]
        most = max(1, _BLOCK // points)
        moved = np.concatenate([
            (self.residuals(vector + part, doubt) - self.residuals(vector - part, doubt)) / 2
            for part in (moves[k:k + most] for k in range(0, len(moves), most))])
        rows = np.zeros((len(vector), moved.shape[1]))
        rows[probes[:-6]] = moved[:-6] / steps[probes[:-6]][:, None]
        own = np.repeat(6 * self.owner, 2)
        for move, number in zip(moved[-6:], poses):
            rows[number + own, np.arange(points)] = move[:points] / steps[number + own]
        return rows

    def solved(self, start, doubt=1.0, flawed=False):
        """Result of a robust least squares from ``start``."""
        return least_squares(
            self.residuals, start, lambda vector, doubt: self.derivatives(
                vector, _PROBE * np.maximum(np.abs(vector), 1e-3), doubt, flawed).T,
            method="dogbox", x_scale="jac", loss="huber", f_scale=_ROBUST, max_nfev=100, ftol=1e-6,
            args=(doubt,))

    def searched(self):
        """Vector of the best fit, how much the usual counts in it, and whether it has flaws."""
        guesses = sorted((_guess(self.size, focal * self.size[0], self.indices, self.points)
                          for focal in _FOCALS),
                         key=lambda guess: np.median(np.abs(self.residuals(guess))))
        best = min(map(self.solved, guesses[:2]), key=lambda result: result.cost)
        plain = self._refined(best, False)
        flawed = self._refined(self.solved(plain[0], 1.0, True), True)
        return min((plain, flawed), key=lambda fit: self._left(fit[0]) / _EXPLAINS[fit[2]])

    def _refined(self, best, flawed):
        """:meth:`searched` from the result ``best``: the usual counts for less, the better it is.
        """
        doubt = 1.0
        for _ in range(_ROUNDS):
            now = float(np.clip(self._left(best.x) / (_LEFT * self.size[0]), _LEAST.min(), 1.0))
            if not now < _SETTLED * doubt:
                break
            doubt, best = now, self.solved(best.x, now, flawed)
        return best.x, doubt, flawed

    def _left(self, vector):
        """What a lens usually leaves on one axis, in pixels."""
        return float(np.median(np.abs(self.errors(vector))))


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


class _Tilts:
    """Tilted sensors, one a vector, that take arrays (..., n)."""

    def __init__(self, angles):
        matrices = [_tilt(*pair) for pair in angles.reshape(-1, 2).tolist()]
        self.matrix = np.moveaxis(np.reshape(matrices, (*angles.shape[:-1], 1, 3, 3)), (-2, -1),
                                  (0, 1))

    def distort(self, x, y):
        """Point on the tilted sensor of a point on the parallel one."""
        return TiltedSensor.distort(self, x, y)


@lru_cache(maxsize=64)
def _tilt(about_x, about_y):
    return TiltedSensor((about_x, about_y)).matrix


def _unpack(vectors):
    """Lens and planes (..., photos, 3, 3) of vectors (..., m): the lens, then six numbers per
    photo. The numbers of the lens have a last axis of length one, for points."""
    focal, cx, cy, *rest = (vectors[..., k, None] for k in range(_LENS))
    k, (p0, p1, p2, p3, s0, s2, _, _, aspect, ratio) = rest[:_TERMS], rest[_TERMS:]
    aspect, ratio = (1 + most * np.tanh(value / most)
                     for value, most in zip((aspect, ratio), _MOST))
    lens = SimpleNamespace(
        focal=focal, centre=(cx, cy), aspect=aspect, radial=SimpleNamespace(k=k),
        decentring=BrownWeng(p=(p0, p1, p2, p3), s=(s0, 0.0, s2, 0.0)),
        tilt=_Tilts(vectors[..., _LENS - 4:_LENS - 2]))
    poses = vectors[..., _LENS:].reshape(*vectors.shape[:-1], -1, 6)
    turns = Rotation.from_rotvec(poses[..., :3].reshape(-1, 3)).as_matrix()
    turns = turns.reshape(*poses.shape[:-1], 3, 3)
    planes = np.stack([turns[..., 0], ratio[..., None] * turns[..., 1], poses[..., 3:]], axis=-1)
    return lens, planes


def _camera(vector, size):
    """The :class:`Camera` of one vector."""
    lens, _ = _unpack(vector)
    (focal,), (aspect,), ((cx,), (cy,)) = lens.focal, lens.aspect, lens.centre
    return Camera(
        size=tuple(size), radial=KannalaBrandt(tuple(float(k[0]) for k in lens.radial.k)),
        focal=float(focal), centre=(float(cx), float(cy)),
        frame=Frame(tuple(size), float(focal), (float(cx), float(cy))),
        decentring=BrownWeng(p=tuple(float(p[0]) for p in lens.decentring.p),
                             s=tuple(float(np.ravel(s)[0]) for s in lens.decentring.s)),
        tilt=TiltedSensor(tuple(vector[_LENS - 4:_LENS - 2].tolist())),
        surface=AsymmetricSurface(tuple(size)), aspect=float(aspect))


def _project(camera, x, y, z):
    """Pixels x and y of directions that may be more than 90 degrees off the axis."""
    across = np.hypot(x, y)
    angle = np.arctan2(across, z)
    q = angle * angle
    radius = np.ones_like(q)
    power = q
    for coefficient in camera.radial.k:
        radius = radius + coefficient * power
        power = power * q
    scale = angle * radius / np.maximum(across, 1e-12)
    x, y = camera.tilt.distort(*camera.decentring.distort(x * scale, y * scale))
    return (camera.focal * x + camera.centre[0],
            camera.focal * camera.aspect * y + camera.centre[1])


def _guess(size, focal, indices, points):
    """Parameters of an equidistant lens of ``focal`` pixels, the poses by direct linear fits."""
    centre = (np.array(size) - 1) / 2
    lens = np.concatenate([[focal], centre, _MEAN[3:]])
    return np.concatenate([lens] + [_pose(index, (xy - centre) / focal)
                                    for index, xy in zip(indices, points)])


def _pose(index, flat):
    """Rotation vector and shift that take (i, j, 0) to the directions of points ``flat``.

    The points are those of an equidistant lens of focal length 1.
    """
    angle = np.linalg.norm(flat, axis=1, keepdims=True)
    rays = np.hstack([flat * np.sinc(angle / np.pi), np.cos(angle)])
    # Centred and scaled indices keep the linear system well conditioned.
    middle, spread = index.mean(axis=0), index.std() + 1e-9
    plane = np.column_stack([(index - middle) / spread, np.ones(len(index))])
    a, b, c = rays.T[:, :, None] * plane.T[None].swapaxes(1, 2)
    nothing = np.zeros_like(a)
    system = np.vstack([np.hstack([nothing, -c, b]), np.hstack([c, nothing, -a]),
                        np.hstack([-b, a, nothing])])
    matrix = np.linalg.svd(system, full_matrices=False)[2][-1].reshape(3, 3)
    if np.sum((plane @ matrix.T) * rays) < 0:
        matrix = -matrix
    matrix = matrix @ np.array([[1, 0, -middle[0]], [0, 1, -middle[1]], [0, 0, spread]]) / spread
    first, second, shift = matrix.T
    scale = np.sqrt(np.linalg.norm(first) * np.linalg.norm(second))
    third = np.cross(first, second) / scale
    left, _, right = np.linalg.svd(np.column_stack([first, second, third]))
    turn = left @ np.diag([1, 1, np.linalg.det(left @ right)]) @ right
    return np.concatenate([Rotation.from_matrix(turn).as_rotvec(), shift / scale])
