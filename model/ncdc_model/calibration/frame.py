"""The ideal frame: positions of a flat target's points in a picture without distortion."""

from dataclasses import dataclass, replace

import numpy as np

from ncdc_model.calibration.page_bend import estimate_of, find_bend
from ncdc_model.calibration.points import Fit
from ncdc_model.calibration.quality import Dropped, check_share
from ncdc_model.calibration.same_relief import proven
from ncdc_model.calibration.smooth import MIN_POINTS, SmoothFit, fit_smooth
from ncdc_model.calibration.smooth_errors import Estimate
from ncdc_model.calibration.target_flatness import find_relief
from ncdc_model.lens import Camera, choose_frame
from ncdc_model.nearest import Nearest
from ncdc_model.threads import one_thread
from ncdc_spec.errors import InputError

__all__ = ["IdealFrame", "ideal_frame"]

_MARGIN = 0.05         # of the corrected size: points farther outside are not used in training
_LINES = 3             # rows and columns: two do not separate a lens from a tilted page
_ROUND = "dots", "circles", "acircles"
_GROSS = 8.0           # times the usual residual, but at least 3 pixels: a point whose residual
_GROSS_PIXELS = 3.0    # differs by more from its neighbours' was numbered or detected wrongly


@dataclass(frozen=True)
class IdealFrame:
    """Training pairs and the flat picture to which they belong.

    Parameters
    ----------
    camera : Camera
        The smooth lens, with the corrected frame; describes the points up to ``rms``.
    homographies : tuple of ndarray, shape (3, 3)
        Matrices from (column, row, 1) of each photo's target to corrected pixels.
    corrected, distorted : ndarray, shape (n, 2)
        Pairs (u, v) and (x, y) in pixels. (u, v) is exactly the homography of the index. (x, y) is
        measured, and corrected for the target's dots and relief.
    index : ndarray of int, shape (n, 2)
        Column and row on the target.
    photo : ndarray of int, shape (n,)
        Photo of each pair.
    rms : float
        Root mean square distance, in distorted pixels, of the used points from the smooth lens.
    rejected : dict
        Number of points not used, by their reason, a :class:`Dropped`.
    along, relief : ndarray, shape (n, 2)
        Directions in which a dent of the target moves the points, and the pixels by which (x, y)
        were corrected for relief; see
        :func:`ncdc_model.calibration.target_flatness.find_relief`.
    degrees : tuple of int
        Degree of the polynomial that the smooth lens lacks, per photo.
    names, numbers : tuple
        Names of the photos, and their numbers among the points' photos.
    gross : tuple of (int, (int, int))
        Photo and index of the points that are farther off the smooth lens than their neighbours.
    fits : tuple of Fit
        What was fitted, for :attr:`TargetPoints.fits`.
    estimate : Estimate
        Standard errors of the last of them, with those of a page's bend.
    cells : tuple of ndarray, shape (n, 2)
        Column and row of each photo's points, scaled to the target's distances.
    sag : tuple of (float, float)
        Bend of the page that was taken off the points, in parts of its length, and its standard
        error; zero and not-a-number if no bend is proven.
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
    fits: tuple = ()
    estimate: Estimate | None = None
    cells: tuple = ()
    sag: tuple = (0.0, float("nan"))


@one_thread()
def ideal_frame(points, size=None, zoom="fit"):
    """Training pairs of :class:`TargetPoints` for a corrected picture of ``size`` at ``zoom``.

    A smooth lens and the target's poses are fitted to all photos at once. The flat picture is that
    of a pinhole camera in the same pose. Its rows and columns are parallel to the sensor's at the
    centre of distortion, whatever the rotation and tilt of the target. Its scale and origin follow
    from ``zoom`` (see :func:`ncdc_model.lens.choose_frame`; at zoom 1 the magnification in the
    middle is 1). Lens and perspective shift the centroid of a round dot's picture; this is
    corrected for the size of the dots. The target is taken as flat, unless the user states a
    relief or several photos prove the same one: then the points are corrected for it.

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
                      gross=gross, fits=fitted.fits, estimate=fitted.estimate,
                      cells=tuple(fitted.cells), sag=fitted.sag)


def _usable_photos(points):
    """Photos with enough whole points, their numbers, and the counts of unused points."""
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
    """Whether the points ``index`` (n, 2) are on enough rows and columns and not on one line."""
    if min(len(np.unique(part)) for part in index.T) < _LINES:
        return False
    (a, b), (_, d) = np.cov(index.T)
    return a * d > b * b * (1 + 1e-9)


@dataclass(frozen=True)
class _Fitted:
    """A smooth lens fitted to photos, and their points, corrected for dots, bend and relief.

    ``fits``: a :class:`Fit` each, in the order in which they were made; ``cells``: column and row,
    scaled to the target's distances; ``xy``: distorted pixels; ``sag``: as of :class:`IdealFrame`.
    """
    fits: tuple
    photos: list
    cells: list
    xy: list
    relief: list
    fit: SmoothFit
    estimate: Estimate
    sag: tuple


class _Fits:
    """Fits of the points of photos, made anew or those that go with the points."""

    def __init__(self, points):
        self.size, self.made, self._known = points.size, [], iter(points.fits)

    def next(self, cells, xy, near=None, bent=False):
        """The next :class:`SmoothFit`, and the :class:`Bend` found with it, if ``bent``."""
        photos = list(zip(cells, xy))
        known = next(self._known, None)
        if known:
            fit, bend = SmoothFit.of(self.size, known), known.bend
        else:
            fit = fit_smooth(self.size, photos, near)
            bend = find_bend(self.size, photos, fit) if bent else None
        self.made.append(Fit(fit.vector, fit.prior, fit.flaws, bend))
        return fit, bend


def _fit(points, photos):
    """:class:`_Fitted` of ``photos``, those of :class:`TargetPoints` that have enough points."""
    cells = [photo.index * (1.0, points.aspect) for photo in photos]
    xy, fits, round_dots = [photo.xy for photo in photos], _Fits(points), points.target in _ROUND
    fit, bend = fits.next(cells, xy, bent=not (points.page or round_dots))
    if round_dots:
        xy = [photo.xy - _eccentricity(fit, number, cells[number], photo)
              for number, photo in enumerate(photos)]
        fit, bend = fits.next(cells, xy, fit, not points.page)
    sag = 0.0, float("nan")
    if bend:
        # Twice: the normals of the first fit are those of a lens that took up the bend.
        flat, sag = xy, (bend.sag(cells), bend.error)
        for _ in range(2):
            xy = [there - fit.raised(k, index, bend.height(k, index))
                  for k, (index, there) in enumerate(zip(cells, flat))]
            fit, _ = fits.next(cells, xy, fit)
    relief = [find_relief(photos[k].index, xy[k] - fit.pixels(k, cells[k]), fit.normal(k, cells[k]))
              for k in range(len(photos))]
    relief = _stated(points.page, photos, xy, relief)
    if any(part.found for part in relief):
        xy = [point - part.shift for point, part in zip(xy, relief)]
        fit, _ = fits.next(cells, xy, fit)
    return _Fitted(tuple(fits.made), photos, cells, xy, relief, fit,
                   estimate_of(points.size, list(zip(cells, xy)), fit), sag)


def _stated(page, photos, xy, relief):
    """``relief`` of each photo, taken as flat unless the user states it or several photos prove
    it."""
    if page == "relief":
        return relief
    shown = np.zeros(len(relief), bool)
    if not page:
        index = [photo.index[:len(photo.index) * part.found]
                 for photo, part in zip(photos, relief)]
        shown = proven(index, xy, [part.height for part in relief])
    return [part if there else part.flat for part, there in zip(relief, shown)]


def _pairs(fitted, frame, rejected):
    """The gross points, then arrays of the used points of all photos: (u, v), (x, y), index,
    photo, distance from the smooth lens, direction and shift of the relief.

    The others are counted in ``rejected``.
    """
    fit, size, used_pairs, wrong = fitted.fit, np.array(frame.size), [], []
    residual = [fit.pixels(number, cells) - fitted.xy[number]
                for number, cells in enumerate(fitted.cells)]
    far = [np.linalg.norm(offset, axis=1) for offset in residual]
    limit = max(_GROSS_PIXELS, _GROSS * float(np.median(np.concatenate(far))))
    for number, (cells, distance) in enumerate(zip(fitted.cells, far)):
        rays = fit.rays(number, cells)
        with np.errstate(divide="ignore", invalid="ignore"):
            uv = np.stack(frame.pixel(rays[:, 0] / rays[:, 2], rays[:, 1] / rays[:, 2]), axis=1)
        gross = _distance_from_neighbours(cells, residual[number]) > limit
        margin = _MARGIN * size
        inside = ((uv >= -margin) & (uv <= size - 1 + margin)).all(axis=1)
        inside &= rays[:, 2] > 0
        _count(rejected, Dropped.GROSS, int(gross.sum()))
        wrong += [(number, tuple(key)) for key in fitted.photos[number].index[gross].tolist()]
        _count(rejected, Dropped.OUTSIDE, int((~inside & ~gross).sum()))
        use, relief = inside & ~gross, fitted.relief[number]
        used_pairs.append((uv[use], fitted.xy[number][use], fitted.photos[number].index[use],
                     np.full(int(use.sum()), number), distance[use], relief.along[use],
                     relief.shift[use]))
    return tuple(wrong), [np.concatenate(part) for part in zip(*used_pairs)]


def _distance_from_neighbours(index, residual):
    """Distance of each point's residual from the median of its eight nearest neighbours'."""
    nearest = Nearest(index).query(index, min(9, len(index)))[1][:, 1:]
    return np.linalg.norm(residual - np.median(residual[nearest], axis=1), axis=1)


def _count(rejected, reason, count):
    if count:
        rejected[reason] = rejected.get(reason, 0) + count


def _eccentricity(fit, number, index, photo):
    """Centroid of each dot's picture minus the picture of its centre, (n, 2) pixels.

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
    points = np.array([pixels(offset) for offset in offsets])
    return (mass[:, :, None] * points).sum(axis=0) / mass.sum(axis=0)[:, None] - points[0]
