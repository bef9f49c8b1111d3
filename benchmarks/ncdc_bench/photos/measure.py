"""Detection on the bad photos, compared with the truth."""

import re
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.judged import judged
from ncdc_spec.errors import InputError

__all__ = ["Outcome", "judge", "renumbered", "try_case"]

FALSE = 1.0            # pixels from the truth
ENOUGH = 0.5           # of the visible points that must be found for a photo to count as used


@dataclass(frozen=True)
class Outcome:
    """Result of detection on one photo.

    Parameters
    ----------
    case, photo : str, int
    expect : str
        use, reject or either.
    found, visible, false : int
        Points found; visible points of the target with the most found ones; found ones that are
        wrong. Wrong are those more than 1 pixel off, of no target or misnumbered, and those more
        than 1 pixel from the flat page that fits the found ones best.
    worst : float
        Pixels of the worst point that is not false; not-a-number without one.
    cut_false : int
        False ones among the dots that the border cuts. These are reported as cut; no fit uses
        them, and they do not count as found.
    message : str
        Why it was rejected, or the warnings; empty if it was used without a warning.
    rejected : bool
    points : object
        The found PhotoPoints, or None.
    word : str
        Regular expression that a warning of false points must match.
    """
    case: str
    photo: int
    expect: str
    found: int
    visible: int
    false: int
    worst: float
    cut_false: int
    message: str
    rejected: bool
    points: object
    word: str = ""

    @property
    def used(self):
        """Whether at least half of the visible points were found."""
        return not self.rejected and self.found - self.false >= ENOUGH * self.visible

    @property
    def silent(self):
        """Whether something false came out without a warning."""
        wrong = self.false > 0 or (self.expect == "reject" and not self.rejected)
        return wrong and not self.rejected and not (
            self.message and re.search(self.word, self.message))

    @property
    def right(self):
        """Whether the result is the expected one."""
        if self.expect == "use":
            return self.used and not self.false
        return not self.silent and (self.rejected or self.expect == "either")


def try_case(case, photos):
    """Outcomes of the photos of one :class:`ncdc_bench.photos.cases.Case`, found together."""
    names = [f"{k}.png" for k in range(len(photos))]
    try:
        points = detect_points([(name, photo.image) for name, photo in zip(names, photos)],
                               case.target)
        found, rejected = {photo.name: photo for photo in points.photos}, points.rejected_photos
        message = judged(points)[2]
    except InputError as error:
        found, rejected, message = {}, dict.fromkeys(names, str(error)), []
    return [_outcome(case, k, photo, found.get(name), rejected.get(name), message)
            for k, (name, photo) in enumerate(zip(names, photos))]


def _outcome(case, number, photo, points, rejected, warnings):
    if points is None:
        return Outcome(case.name, number, case.expect[number], 0, _visible(photo), 0, np.nan, 0,
                       rejected or "not there", True, None)
    visible, false, worst, cut_false = judge(photo, points)
    name = f"{number}.png"
    message = "; ".join(text for text in warnings if ".png" not in text or name in text)
    return Outcome(case.name, number, case.expect[number], len(points.whole.index), visible, false,
                   worst, cut_false, message, False, points, case.word)


def _visible(photo):
    return max((int(truth.visible.sum()) for truth in photo.truths), default=0)


def judge(photo, points):
    """(visible, false, worst, cut_false) of found PhotoPoints, from a :class:`Photo`'s truth.

    All points must belong to one target, and their index must be the target's up to one turn,
    mirroring and shift for all.
    """
    best = _visible(photo), len(points.whole.index), np.nan, int(points.cut.sum())
    for truth in photo.truths:
        near, which = cKDTree(truth.xy).query(points.xy)
        close = near <= FALSE
        if close.sum() < 3:
            continue
        index = renumbered(points.index, truth.index[which], close)
        position = {tuple(key): xy for key, xy in zip(truth.index.tolist(), truth.xy)}
        off = np.array([np.linalg.norm(position[tuple(key)] - xy) if tuple(key) in position
                        else np.inf for key, xy in zip(index.tolist(), points.xy)])
        far, cut = off > FALSE, points.cut
        if truth.lens is not None and (~far & ~cut).sum() >= 8:
            on = ~far & ~cut
            far[on] = truth.lens.off_flat(index[on], points.xy[on]) > FALSE
        worst = float(off[~far].max()) if not far.all() else np.nan
        result = int(truth.visible.sum()), int((far & ~cut).sum()), worst, int((far & cut).sum())
        if result[1] < best[1]:
            best = result
    return best


def renumbered(index, true, close):
    """``index`` turned, mirrored and shifted so that most points have the ``true`` one."""
    best, count = index, -1
    turns = [np.array([[a, 0], [0, b]]) for a in (1, -1) for b in (1, -1)]
    for turn in [*turns, *(matrix[::-1] for matrix in turns)]:
        moved = index @ turn
        shifts, votes = np.unique((true - moved)[close], axis=0, return_counts=True)
        if votes.max() > count:
            best, count = moved + shifts[votes.argmax()], votes.max()
    return best
