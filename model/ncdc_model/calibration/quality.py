"""Warnings about points that a network should not be trained on without a second look."""

from enum import Enum

import numpy as np

__all__ = ["Dropped", "check_share", "warnings_of"]

_SCATTER = 0.25        # pixels: a point farther off its line's smooth course than this is noisy
_LOST = 0.02           # of the places within the target that have no point
_DROPPED = 0.02        # of the points that disagree with their neighbours
_RUINED = 0.10         # the same: beyond this it is not a few points that are wrong


class Dropped(Enum):
    """Why a point is not used. Programs compare the member; its value is the text for people."""
    CUT = "cut by the border"
    FEW = "in a photo with too few points"
    GROSS = "off the smooth lens by more than its neighbours"
    OUTSIDE = "outside the corrected frame"


def check_share(rejected, count):
    """One sentence if so many of ``count`` points disagree that the rest can not be trusted."""
    wrong = rejected.get(Dropped.GROSS, 0)
    if wrong > _RUINED * count:
        return (f"{wrong} of {count} points, {100 * wrong / count:.1f} %, disagree with their "
                f"neighbours, {100 * _RUINED:.0f} % is the limit: indices or points are wrong")
    return None


def warnings_of(points, frame, scatter):
    """What is odd about :class:`TargetPoints` and their :class:`IdealFrame`, a sentence each.

    ``scatter`` is how far a point is from its line's smooth course, rms, in distorted pixels.
    """
    found = []
    if scatter > _SCATTER:
        found.append(f"the points scatter by {scatter:.2f} px rms about their lines, more than "
                     f"{_SCATTER} px: noise, blur or motion")
    for photo in points.photos:
        places, lost = _places(photo.index)
        if lost > _LOST * places:
            found.append(f"{photo.name}: {lost} of {places} places between other points, "
                         f"{100 * lost / places:.1f} %, have no point")
    wrong, count = frame.rejected.get(Dropped.GROSS, 0), points.count
    if wrong > _DROPPED * count:
        found.append(f"{wrong} of {count} points, {100 * wrong / count:.1f} %, disagree with their "
                     f"neighbours and are not used: indices or points may be wrong")
    return found


def _places(index):
    """Places that have points on both sides in their row and in their column; those without one."""
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
    if parities.min() == 0:            # staggered: every other place is none
        inside &= (i + j) % 2 == int(parities.argmax())
    return int(inside.sum()), int((inside & ~there).sum())
