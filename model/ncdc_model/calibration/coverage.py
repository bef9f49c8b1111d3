"""What of the lattice that is seen is not used: many points, whole lines, or a region."""

from collections import Counter

import numpy as np
from scipy import ndimage
from scipy.spatial import cKDTree

__all__ = ["uncovered"]

_UNUSED = 0.10         # of the points seen on the lattice
_FEW = 5               # points: fewer are no tenth of anything
_LINE = 0.25           # of the points seen on a line: if no more are used, the line is left out
_REGION = 9            # connected places of a region
_LARGE = 0.02          # the same, of all places
_STRAY = "not on the grid"


def uncovered(photo, name="", staggered=False):
    """Sentences on what of a photo's lattice is not used, PhotoPoints; a list.

    The points that had a number and were dropped get one again from the used points next to them.
    More than a tenth of all is named with its reasons, a row or column of which a quarter or less
    is used with its number, and so is a region of at least nine places without a point.
    """
    photo = photo.whole
    dropped = [(x, y, reason) for x, y, reason in photo.dropped if reason != _STRAY]
    index = _halved(photo.index) if staggered else photo.index
    where = placed(index, photo.xy, np.array([place[:2] for place in dropped]).reshape(-1, 2))
    used = set(map(tuple, index.tolist()))
    unused = {tuple(key): k for k, key in enumerate(where.tolist()) if tuple(key) not in used}
    found, head = [], f"{name}: " if name else ""
    seen = len(used) + len(unused)
    if len(unused) > max(_UNUSED * seen, _FEW):
        reasons = Counter(dropped[k][2] for k in unused.values()).most_common(2)
        found.append(f"{head}{len(unused)} of {seen} points seen on the lattice, "
                     f"{100 * len(unused) / seen:.0f} %, are not used, most around "
                     f"{_spot(np.array([dropped[k][:2] for k in unused.values()]))}: "
                     + "; ".join(f"{count} {reason}" for reason, count in reasons))
    if not staggered:
        found += _lines(head, index, photo.xy, unused, dropped)
    return found + _regions(head, index, photo.xy)


def placed(index, xy, more):
    """Column and row (k, 2) of further places ``more`` (k, 2), nearest first, each from the six
    points that have a number and lie next to it; the first with one keeps it."""
    numbers, places = index.astype(float), xy.copy()
    result = np.full((len(more), 2), -10**6)
    for k in np.argsort(cKDTree(xy).query(more)[0]) if len(more) and len(xy) >= 6 else ():
        near = cKDTree(places).query(more[k], 6)[1]
        terms = np.column_stack([places[near] - more[k], np.ones(6)])
        number = np.rint(np.linalg.lstsq(terms, numbers[near], rcond=1e-6)[0][2])
        result[k] = number
        numbers, places = np.vstack([numbers, number]), np.vstack([places, more[k]])
    return result


def _lines(head, index, xy, unused, dropped):
    """Rows and columns that were seen, nearly as long as the others, and are not used."""
    every = np.vstack([index, np.array(list(unused), int).reshape(-1, 2)])
    places = np.vstack([xy, np.array([dropped[k][:2] for k in unused.values()]).reshape(-1, 2)])
    taken, found = np.arange(len(every)) < len(index), []
    for axis, name in enumerate(("column", "row")):
        lines, counts = np.unique(every[:, axis], return_counts=True)
        out = [line for line, count in zip(lines.tolist(), counts)
               if count >= max(4, 0.5 * np.median(counts))
               and taken[every[:, axis] == line].sum() <= _LINE * count]
        for first, last in _runs(out):
            on = (every[:, axis] >= first) & (every[:, axis] <= last)
            ends = places[on][np.argsort(every[on, 1 - axis])][[0, -1]]
            lines = f"{name} {first} is" if first == last else f"{name}s {first} to {last} are"
            found.append(f"{head}{lines} left out, from ({ends[0, 0]:.0f}, {ends[0, 1]:.0f}) to "
                         f"({ends[1, 0]:.0f}, {ends[1, 1]:.0f}): {taken[on].sum()} of {on.sum()} "
                         f"points seen there are used")
    return found


def _runs(numbers):
    """First and last of the runs of consecutive numbers, rising."""
    parts = np.split(np.array(numbers), np.flatnonzero(np.diff(numbers) > 1) + 1)
    return [(part[0], part[-1]) for part in parts if len(part)]


def _regions(head, index, xy):
    """Regions within the lattice that have no point."""
    origin = index.min(axis=0)
    there = np.zeros(np.ptp(index, axis=0) + 1, bool)
    there[tuple((index - origin).T)] = True
    inside = np.ones_like(there)
    for axis in (0, 1):
        before = np.logical_or.accumulate(there, axis=axis)
        inside &= before & np.flip(np.logical_or.accumulate(np.flip(there, axis), axis=axis), axis)
    labels, count = ndimage.label(inside & ~there)
    found = []
    for number in range(1, count + 1):
        places = np.argwhere(labels == number) + origin
        if len(places) >= max(_REGION, _LARGE * inside.sum()):
            near = cKDTree(index).query(places, 3)[1].ravel()
            found.append(f"{head}a region of {len(places)} places of the lattice has no point, "
                         f"around {_spot(xy[near])}, columns {places[:, 0].min()} to "
                         f"{places[:, 0].max()}, rows {places[:, 1].min()} to {places[:, 1].max()}")
    return found


def _spot(xy):
    x, y = np.median(xy, axis=0)
    return f"({x:.0f}, {y:.0f})"


def _halved(index):
    """Of a staggered grid: numbers along its two oblique steps."""
    a, b = (index - index[0]).T
    return np.stack([(a + b) // 2, (a - b) // 2], axis=1)
