"""Unused parts of the visible lattice: many points, whole lines, or a region."""

from collections import Counter

import cv2
import numpy as np

from ncdc_model.nearest import Nearest

__all__ = ["uncovered"]

_UNUSED = 0.10         # of the points seen on the lattice
_FEW = 5               # points: fewer are not reported
_LINE = 0.25           # of the points seen on a line: a line with no more used ones is reported
_REGION = 9            # connected lattice positions without a point that are reported
_LARGE = 0.02          # the same, in parts of all positions
_STRAY = "not on the grid"


def uncovered(photo, name="", staggered=False):
    """List of sentences on the unused parts of the lattice of a photo, PhotoPoints.

    Dropped points get a number again from the used points next to them. More than a tenth of all
    points is reported with its reasons, and a row or column of which a quarter or less is used
    with its number. So is a region of at least nine positions without a point.
    """
    photo = photo.whole
    dropped = [(x, y, reason) for x, y, reason in photo.dropped if reason != _STRAY]
    index = _halved(photo.index) if staggered else photo.index
    where = numbered(index, photo.xy, np.array([point[:2] for point in dropped]).reshape(-1, 2))
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


def numbered(index, xy, more):
    """Column and row (k, 2) of further positions ``more`` (k, 2).

    Each is extrapolated from the six nearest numbered points; the nearest positions come first.
    """
    numbers, positions = index.astype(float), xy.copy()
    result = np.full((len(more), 2), -10**6)
    for k in np.argsort(Nearest(xy).query(more)[0][:, 0]) if len(more) and len(xy) >= 6 else ():
        near = Nearest(positions).query(more[k], 6)[1][0]
        terms = np.column_stack([positions[near] - more[k], np.ones(6)])
        number = np.rint(np.linalg.lstsq(terms, numbers[near], rcond=1e-6)[0][2])
        result[k] = number
        numbers, positions = np.vstack([numbers, number]), np.vstack([positions, more[k]])
    return result


def _lines(head, index, xy, unused, dropped):
    """Sentences on rows and columns nearly as long as the others that are not used."""
    every = np.vstack([index, np.array(list(unused), int).reshape(-1, 2)])
    positions = np.vstack([xy, np.array([dropped[k][:2] for k in unused.values()]).reshape(-1, 2)])
    taken, found = np.arange(len(every)) < len(index), []
    for axis, name in enumerate(("column", "row")):
        lines, counts = np.unique(every[:, axis], return_counts=True)
        out = [line for line, count in zip(lines.tolist(), counts)
               if count >= max(4, 0.5 * np.median(counts))
               and taken[every[:, axis] == line].sum() <= _LINE * count]
        for first, last in _runs(out):
            on = (every[:, axis] >= first) & (every[:, axis] <= last)
            ends = positions[on][np.argsort(every[on, 1 - axis])][[0, -1]]
            lines = f"{name} {first} is" if first == last else f"{name}s {first} to {last} are"
            found.append(f"{head}{lines} left out, from ({ends[0, 0]:.0f}, {ends[0, 1]:.0f}) to "
                         f"({ends[1, 0]:.0f}, {ends[1, 1]:.0f}): {taken[on].sum()} of {on.sum()} "
                         f"points seen there are used")
    return found


def _runs(numbers):
    """First and last of each run of consecutive numbers, ascending."""
    parts = np.split(np.array(numbers), np.flatnonzero(np.diff(numbers) > 1) + 1)
    return [(part[0], part[-1]) for part in parts if len(part)]


def _regions(head, index, xy):
    """Sentences on regions within the lattice that have no point."""
    origin = index.min(axis=0)
    there = np.zeros(np.ptp(index, axis=0) + 1, bool)
    there[tuple((index - origin).T)] = True
    inside = np.ones_like(there)
    for axis in (0, 1):
        before = np.logical_or.accumulate(there, axis=axis)
        inside &= before & np.flip(np.logical_or.accumulate(np.flip(there, axis), axis=axis), axis)
    count, labels = cv2.connectedComponents((inside & ~there).view(np.uint8), connectivity=4)
    found = []
    for number in range(1, count):
        positions = np.argwhere(labels == number) + origin
        if len(positions) >= max(_REGION, _LARGE * inside.sum()):
            near = Nearest(index).query(positions, 3)[1].ravel()
            found.append(f"{head}a region of {len(positions)} positions of the lattice has no "
                         f"point, around {_spot(xy[near])}, columns {positions[:, 0].min()} to "
                         f"{positions[:, 0].max()}, rows {positions[:, 1].min()} to "
                         f"{positions[:, 1].max()}")
    return found


def _spot(xy):
    x, y = np.median(xy, axis=0)
    return f"({x:.0f}, {y:.0f})"


def _halved(index):
    """Numbers along the two oblique steps of a staggered grid."""
    a, b = (index - index[0]).T
    return np.stack([(a + b) // 2, (a - b) // 2], axis=1)
