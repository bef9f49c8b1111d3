"""Warnings about points that should be checked before a network is trained on them."""

from enum import Enum

import numpy as np

from ncdc_model.calibration.coverage import uncovered
from ncdc_model.calibration.seams import find_seam, seam_text
from ncdc_model.nearest import Nearest

__all__ = ["Dropped", "bent", "check_share", "uneven", "warnings_of"]

_SCATTER = 0.25        # pixels from a line's smooth course: a point farther off is noisy
_LOST = 0.02           # of the positions within the target that have no point
_DROPPED = 0.02        # of the points that disagree with their neighbours
# Pixels on an axis: if points scatter by more, some may be off by a pixel. Centroids of circles on
# clean photos scatter by up to 0.30, corners by up to 0.16.
_UNSURE, _UNSURE_CORNERS = 0.35, 0.22
_PALE = 0.50           # contrast of dots in parts of the page's brightness: blurred ones have less
_BENT = 1.0            # pixels rms: lines that are less straight are wrong
# Pixels, and parts of the picture's width: largest rms residual of the smooth lens on one photo of
# an even target. The last is the factor for several photos, which determine the lens better.
_UNEVEN, _UNEVEN_WIDTH, _UNEVEN_MANY = 0.15, 1 / 8000, 4.0
_AROUND = 9            # points whose median is the residual at a position
_ODD = 5.0             # times the usual distance from the lens: a photo farther off is odd
_RUINED = 0.10         # the same: with more, the points cannot be used


class Dropped(Enum):
    """Why a point is not used. Programs compare the member; its value is the text for people."""
    CUT = "cut by the border"
    FEW = "in a photo with too few points"
    GROSS = "off the smooth lens by more than its neighbours"
    OUTSIDE = "outside the corrected frame"


def check_share(rejected, count):
    """One sentence if so many of ``count`` points disagree that the rest cannot be trusted."""
    wrong = rejected.get(Dropped.GROSS, 0)
    if wrong > _RUINED * count:
        return (f"{wrong} of {count} points, {100 * wrong / count:.1f} %, disagree with their "
                f"neighbours, {100 * _RUINED:.0f} % is the limit: indices or points are wrong")
    return None


def warnings_of(points, frame, measured):
    """Sentences on what is odd about :class:`TargetPoints` and their :class:`IdealFrame`.

    ``measured``: result of :func:`ncdc_model.calibration.measure.measure_smooth` for the frame.
    """
    found, scatter = [], measured["repeatability_px"]
    unsure = _UNSURE_CORNERS if points.target in ("chessboard", "charuco") else _UNSURE
    for photo in points.photos:
        if photo.agreement > unsure:
            found.append(f"{photo.name}: points usually lie {photo.agreement:.2f} px from where "
                         f"their neighbours predict them, more than {unsure} px: some may "
                         f"be off by more than a pixel")
        if photo.contrast < _PALE:
            found.append(f"{photo.name}: dots are usually only {100 * photo.contrast:.0f} % darker "
                         f"than the page, less than {100 * _PALE:.0f} %: out of focus or "
                         f"overexposed, points at the edge may be off by more than a pixel")
        found += [f"{photo.name}: {text}" for text in photo.warnings]
        found += uncovered(photo, photo.name, points.target == "acircles")
    found += _seams(frame, points)
    found += _odd_photos(frame)
    found += bent(frame) + uneven(points, frame)
    if measured["straightness_rms_px"] > _BENT:
        found.append(f"rows and columns are straight to {measured['straightness_rms_px']:.1f} px "
                     f"rms only, {_BENT} px is the limit: points are wrong, or no smooth lens "
                     f"describes this one")
    if scatter > _SCATTER:
        found.append(f"the points scatter by {scatter:.2f} px rms about their lines, more than "
                     f"{_SCATTER} px: noise, blur or motion")
    for photo in points.photos:
        positions, lost = _positions(photo.index)
        if lost > _LOST * positions:
            found.append(f"{photo.name}: {lost} of {positions} positions between other points, "
                         f"{100 * lost / positions:.1f} %, have no point")
    wrong, count = frame.rejected.get(Dropped.GROSS, 0), points.count
    if wrong > _DROPPED * count:
        found.append(f"{wrong} of {count} points, {100 * wrong / count:.1f} %, disagree with their "
                     f"neighbours and are not used: indices or points may be wrong")
    return found


def _seams(frame, points):
    """A sentence for each photo whose lattice has a step."""
    if points.target == "acircles":
        return []
    rest, found = -_residuals(frame), []
    for number, name in enumerate(frame.names):
        on = frame.photo == number
        seam = find_seam(frame.index[on], frame.distorted[on], rest[on],
                         points.size[0]) if on.any() else None
        if seam:
            found.append(f"{name}: {seam_text(seam)}")
    return found


def bent(frame):
    """List of one sentence if the photos show that the page is bent; empty if not."""
    sag, error = frame.sag
    if not sag:
        return []
    return [f"the page is bent: its height differs by {100 * sag:.2f} ± {100 * error:.2f} % of "
            f"its length on one photo. The photos prove it, and it is taken off the points; a "
            f"flat page measures better. --flat states that it is flat"]


def uneven(points, frame):
    """List of one sentence, with size and position, if no smooth lens explains the points of a flat
    target; empty if the user states that it is flat."""
    rest = _residuals(frame)
    scatter = float(np.nanmean([0.0, *(photo.agreement for photo in points.photos)]))
    rms = float(np.sqrt(max(np.mean((rest**2).sum(axis=1)) - 2 * scatter**2, 0)))
    limit = max(_UNEVEN, _UNEVEN_WIDTH * points.size[0])
    if points.page == "flat" or rms <= limit * (1 if len(frame.names) == 1 else _UNEVEN_MANY):
        return []
    # A single wrong point is no bend: take the median of the points around each.
    near = Nearest(frame.distorted).query(frame.distorted, min(_AROUND, len(rest)))[1]
    off = np.linalg.norm(np.median(rest[near], axis=1), axis=1)
    (x, y), worst = frame.distorted[off.argmax()], off.max()
    done = "after its relief was taken off, " if frame.relief.any() else ""
    state = "" if points.page else ", --relief that it has a relief"
    return [f"{', '.join(frame.names[:3])}: {done}the points lie {rms:.2f} px rms, {worst:.1f} px "
            f"around ({x:.0f}, {y:.0f}), off the best smooth lens, which leaves {limit:.2f} px at "
            f"most of an even lens and a flat page. The page may be bent or of two sheets, or the "
            f"lens is uneven here. If the page is bent, the map is off by more than that. --flat "
            f"states that it is flat{state}"]


def _residuals(frame):
    """Pixels (n, 2) from each point to the smooth lens's prediction."""
    return np.stack(frame.camera.back_map(*frame.corrected.T), axis=1) - frame.distorted


def _odd_photos(frame):
    """Sentences on photos whose points are much farther off the common lens than the others'."""
    off = np.linalg.norm(_residuals(frame), axis=1)
    medians = [float(np.median(off[frame.photo == k])) if (frame.photo == k).any() else 0.0
               for k in range(len(frame.names))]
    usual = float(np.median(medians))
    return [f"{name}: its points lie {value:.1f} px from the lens that all photos share, other "
            f"photos' {usual:.1f} px: the target moved, bent, or is another one"
            for name, value in zip(frame.names, medians)
            if len(medians) > 2 and value > max(_ODD * usual, 1.0)]


def _positions(index):
    """Count of positions between points in both their row and column, and of those without one."""
    index = index - index.min(axis=0)
    there = np.zeros(index.max(axis=0) + 1, bool)
    there[tuple(index.T)] = True
    inside = np.ones_like(there)
    for axis in (0, 1):
        before = np.logical_or.accumulate(there, axis=axis)
        after = np.flip(np.logical_or.accumulate(np.flip(there, axis), axis=axis), axis)
        inside &= before & after
    i, j = np.indices(there.shape)
    parities = np.bincount((i + j)[there] % 2, minlength=2)
    if parities.min() == 0:            # staggered: every other position is empty
        inside &= (i + j) % 2 == int(parities.argmax())
    return int(inside.sum()), int((inside & ~there).sum())
