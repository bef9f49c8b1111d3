"""The ideal frame: what a flat target's points are in a picture without distortion."""

from dataclasses import dataclass, replace

import numpy as np
from scipy.spatial import cKDTree

from ncdc_model.calibration.quality import Dropped, check_share
from ncdc_model.calibration.relief import find_relief
from ncdc_model.calibration.same_relief import proven
from ncdc_model.calibration.smooth import MIN_POINTS, fit_smooth
from ncdc_model.lens import Camera, choose_frame
from ncdc_model.threads import one_thread
from ncdc_spec.errors import InputError

__all__ = ["IdealFrame", "ideal_frame"]

_MARGIN = 0.05         # of the corrected size: points farther outside do not help to train
_LINES = 3             # rows and columns: with two, nothing tells a lens from a tilted page
_ROUND = "dots", "circles", "acircles"
_GROSS = 8.0           # times the usual residual, but at least 3 pixels: farther from the smooth
_GROSS_PIXELS = 3.0    # lens than its neighbours are, a point was numbered or detected wrongly


@dataclass(frozen=True)
class IdealFrame:
    """Training pairs, and the flat picture that they belong to.

    Parameters
    ----------
    camera : Camera
        The smooth lens, with the corrected frame; describes the points up to ``rms``.
    homographies : tuple of ndarray, shape (3, 3)
        Take (column, row, 1) of each photo's target to corrected pixels.
    corrected, distorted : ndarray, shape (n, 2)
        Pairs (u, v) and (x, y) in pixels. (u, v) are exactly the homography's of the index;
        (x, y) are measured, less what the target's dots and relief move them by.
    index : ndarray of int, shape (n, 2)
        Column and row on the target.
    photo : ndarray of int, shape (n,)
        Which photo each pair is from.
    rms : float
        Root mean square distance, in distorted pixels, of the used points from the smooth lens.
    rejected : dict
        How many points were not used, by their reason, a :class:`Dropped`.
    along, relief : ndarray, shape (n, 2)
        Directions in which a dent of the target moves the points, and by how many pixels the
        target's relief had moved them before (x, y) were put right; see
        :func:`ncdc_model.calibration.relief.find_relief`.
    degrees : tuple of int
        Of the polynomial that the smooth lens lacks, for each photo.
    names, numbers : tuple
        Of the photos: their names, and which of the points' photos they are.
    gross : tuple of (int, (int, int))
        Photo and index of the points that are off the smooth lens by more than their neighbours.
    """
    camera: Camera
    homographies: tuple
    corrected: np.ndarray
    distorted: np.ndarray
    index: np.ndarray
    photo: np.ndarray
    rms: float
    rejected: dict
    along: np.ndarray
    relief: np.ndarray
    degrees: tuple
    names: tuple
    numbers: tuple
    gross: tuple = ()


@one_thread()
def ideal_frame(points, size=None, zoom="fit"):
    """Training pairs of :class:`TargetPoints` for a corrected picture of ``size`` at ``zoom``.

    A smooth lens and the target's poses are fitted to all photos at once. The flat picture is
    what a pinhole camera in the same place and position sees: its rows and columns are parallel
    to the sensor's at the centre of distortion, whatever the rotation and tilt of the target, and
    its scale and place follow from ``zoom`` (see :func:`ncdc_model.lens.choose_frame`; at zoom
    1 the magnification in the middle is 1). The centre of gravity of a round dot's picture is
    moved by the lens and by perspective; it is corrected for the size of the dots. The target is
    taken as flat. Only if the user states a relief, or several photos prove the same one, is what
    it moves the points by taken off.

    Raises
    ------
    InputError
        If no photo has 12 points, no lens explains them, more than a tenth of them disagree with
        their neighbours, or ``zoom`` does not suit the lens.
    """
    size = tuple(size or points.size)
    photos, numbers, rejected = _usable_photos(points)
    try:
        fitted = _fit(points, photos)
    except (np.linalg.LinAlgError, ValueError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(f"no smooth lens explains the points: {error}") from error
    fit = fitted.fit
    frame = choose_frame(fit.camera.undistort, fit.camera.distort, points.size, size, zoom)
    homographies = [frame.matrix @ plane @ np.diag([1.0, points.aspect, 1.0])
                    for plane in fit.planes]
    gross, pairs = _pairs(fitted, frame, rejected)
    corrected, distorted, used, photo, distance, along, shift = pairs
    if ruined := check_share(rejected, points.whole):
        raise InputError(ruined)
    if len(used) < MIN_POINTS:
        raise InputError(f"{len(used)} points lie inside the corrected frame, at least "
                         f"{MIN_POINTS} are needed")
    return IdealFrame(camera=replace(fit.camera, frame=frame),
                      homographies=tuple(matrix / matrix[2, 2] for matrix in homographies),
                      corrected=corrected, distorted=distorted, index=used, photo=photo,
                      rms=float(np.sqrt(np.mean(distance**2))), rejected=rejected, along=along,
                      relief=shift, degrees=tuple(part.degree for part in fitted.relief),
                      names=tuple(photo.name for photo in photos), numbers=tuple(numbers),
                      gross=gross)


def _usable_photos(points):
    """Photos of enough whole points, their numbers, and how many other points there are."""
    photos, numbers, rejected = [], [], {}
    for number, photo in enumerate(points.photos):
        _count(rejected, Dropped.CUT, int(photo.cut.sum()))
        photo = photo.whole
        if len(photo.index) < MIN_POINTS or not _spread(photo.index):
            _count(rejected, Dropped.FEW, len(photo.index))
        else:
            photos.append(photo)
            numbers.append(number)
    if not photos:
        raise InputError(f"no photo has {MIN_POINTS} whole points on at least {_LINES} rows and "
                         f"{_LINES} columns")
    return photos, numbers, rejected


def _spread(index):
    """Whether the points ``index`` (n, 2) have enough rows and columns, and not on one line."""
    if min(len(np.unique(part)) for part in index.T) < _LINES:
        return False
    (a, b), (_, d) = np.cov(index.T)
    return a * d > b * b * (1 + 1e-9)


@dataclass(frozen=True)
class _Fitted:
    """A smooth lens fitted to photos; of each photo its points, put right for dots and relief.

    ``cells``: column and row, as far apart as the target's; ``xy``: distorted pixels.
    """
    fit: object
    photos: list
    cells: list
    xy: list
    relief: list


def _fit(points, photos):
    """:class:`_Fitted` of ``photos``, those of :class:`TargetPoints` that have enough points."""
    cells = [photo.index * (1.0, points.aspect) for photo in photos]
    xy = [photo.xy for photo in photos]
    fit = fit_smooth(points.size, list(zip(cells, xy)))
    if points.target in _ROUND:
        xy = [photo.xy - _eccentricity(fit, number, cells[number], photo)
              for number, photo in enumerate(photos)]
        fit = fit_smooth(points.size, list(zip(cells, xy)), fit)
    relief = [find_relief(photos[k].index, xy[k] - fit.pixels(k, cells[k]), fit.normal(k, cells[k]))
              for k in range(len(photos))]
    relief = _stated(points.page, photos, xy, relief)
    if any(part.found for part in relief):
        xy = [place - part.shift for place, part in zip(xy, relief)]
        fit = fit_smooth(points.size, list(zip(cells, xy)), fit)
    return _Fitted(fit, photos, cells, xy, relief)


def _stated(page, photos, xy, relief):
    """``relief`` of each photo, taken as flat unless the user says or several photos prove that
    there is one."""
    if page == "relief":
        return relief
    shown = np.zeros(len(relief), bool)
    if not page:
        index = [photo.index[:len(photo.index) * part.found]
                 for photo, part in zip(photos, relief)]
        shown = proven(index, xy, [part.height for part in relief])
    return [part if there else part.flat for part, there in zip(relief, shown)]


def _pairs(fitted, frame, rejected):
    """Points of all photos that are used, as arrays, after those that are gross; the others are
    counted in ``rejected``.

    (u, v), (x, y), index, photo, distance from the smooth lens, direction and shift of the relief.
    """
    fit, size, kept, wrong = fitted.fit, np.array(frame.size), [], []
    residual = [fit.pixels(number, cells) - fitted.xy[number]
                for number, cells in enumerate(fitted.cells)]
    far = [np.linalg.norm(offset, axis=1) for offset in residual]
    limit = max(_GROSS_PIXELS, _GROSS * float(np.median(np.concatenate(far))))
    for number, (cells, distance) in enumerate(zip(fitted.cells, far)):
        rays = fit.rays(number, cells)
        with np.errstate(divide="ignore", invalid="ignore"):
            uv = np.stack(frame.pixel(rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]), axis=1)
        gross = _against_neighbours(cells, residual[number]) > limit
        margin = _MARGIN * size
        inside = ((uv >= -margin) & (uv <= size - 1 + margin)).all(axis=1)
        inside &= rays[:, 2] > 0
        _count(rejected, Dropped.GROSS, int(gross.sum()))
        wrong += [(number, tuple(key)) for key in fitted.photos[number].index[gross].tolist()]
        _count(rejected, Dropped.OUTSIDE, int((~inside & ~gross).sum()))
        use, relief = inside & ~gross, fitted.relief[number]
        kept.append((uv[use], fitted.xy[number][use], fitted.photos[number].index[use],
                     np.full(int(use.sum()), number), distance[use], relief.along[use],
                     relief.shift[use]))
    return tuple(wrong), [np.concatenate(part) for part in zip(*kept)]


def _against_neighbours(index, residual):
    """Distance of each point's residual from the median of its eight nearest neighbours'."""
    nearest = cKDTree(index).query(index, min(9, len(index)))[1][:, 1:]
    return np.linalg.norm(residual - np.median(residual[nearest], axis=1), axis=1)


def _count(rejected, reason, count):
    if count:
        rejected[reason] = rejected.get(reason, 0) + count


def _eccentricity(fit, number, index, photo):
    """Centre of gravity of each dot's picture minus the picture of its centre, (n, 2) pixels.

    The dots' radius on the target follows from their areas. The integrals over a disc are those
    of the seven-point formula of degree five.
    """
    def pixels(offset):
        return fit.pixels(number, index + np.asarray(offset, np.float64))

    def stretch(offset, h=1e-3):
        change = (pixels(np.add(offset, d)) - pixels(np.subtract(offset, d))
                  for d in ((h, 0), (0, h)))
        (xa, ya), (xb, yb) = (pair.T / (2 * h) for pair in change)
        return np.abs(xa * yb - xb * ya)
    usable = photo.area > 0
    if not usable.any():
        return np.zeros_like(photo.xy)
    radius = np.sqrt(np.median((photo.area / stretch((0, 0)))[usable]) / np.pi)
    turns = np.arange(6) * np.pi / 3
    ring = radius * np.sqrt(2 / 3) * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    offsets, weights = np.vstack([[0, 0], ring]), np.array([1 / 4] + [1 / 8] * 6)
    mass = np.array([weight * stretch(offset) for weight, offset in zip(weights, offsets)])
    places = np.array([pixels(offset) for offset in offsets])
    return (mass[:, :, None] * places).sum(axis=0) / mass.sum(axis=0)[:, None] - places[0]
