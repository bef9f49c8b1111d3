"""Finds the markers of Kalibr's AprilGrid and reads from their numbers how they are arranged."""

from collections import Counter
from dataclasses import dataclass

import cv2
import numpy as np

__all__ = ["FAMILY", "Tags", "april_family", "find_tags"]

FAMILY = "DICT_APRILTAG_36h11"
_BORDERS = 2, 1        # cells of the black border: Kalibr's, and what AprilTag itself prints
_COPY = 1600           # pixels of the longer side: of a larger photo a copy is searched
_BLUR = 1.0            # pixels: the sites of a raw frame differ from one to the next
_LARGE = 30            # pixels: where tags are that large none is missed
_ENOUGH = 3            # tags whose numbers fit their places
_NEAR = 1.02, 2.1      # sides of a tag from its middle to that of the next
_ASIDE = 0.4           # the same, at a right angle to that


@dataclass(frozen=True)
class Tags:
    """Tags whose numbers fit their places.

    Parameters
    ----------
    ids : ndarray of int, shape (n,)
    corners : ndarray, shape (n, 4, 2)
        Pixels of the upper left corner, and on clockwise; up is where the board's rows end or
        begin, right where the numbers grow by one.
    columns : int or None
        Tags in a row of the board; None if only one row is seen.
    upwards : bool
        Whether the numbers grow upwards, as Kalibr's do.
    turn : int
        Quarter turns, anticlockwise, of OpenCV's picture of a tag on the board.
    border : int
        Cells of the black border of a tag.
    foreign : int
        Other tags, whose numbers do not fit their places.
    """
    ids: np.ndarray
    corners: np.ndarray
    columns: int | None
    upwards: bool
    turn: int
    border: int
    foreign: int


def april_family():
    """OpenCV's dictionary of the tags."""
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, FAMILY))


def find_tags(grey):
    """:class:`Tags` of the grey uint8 picture; None if no three tags are next to each other."""
    for border in _BORDERS:
        ids, corners = _detected(grey, border)
        found = _arranged(ids, corners, border) if len(ids) >= _ENOUGH else None
        if found is not None:
            return found
    return None


def _detected(grey, border):
    """Numbers (n,) and corners (n, 4, 2) in pixels of all tags."""
    settings = cv2.aruco.DetectorParameters()
    settings.markerBorderBits = border
    detector = cv2.aruco.ArucoDetector(april_family(), settings)
    part = -(-max(grey.shape) // _COPY)
    if part > 1:
        copy = cv2.resize(grey[:grey.shape[0] // part * part, :grey.shape[1] // part * part], None,
                          fx=1 / part, fy=1 / part, interpolation=cv2.INTER_AREA)
        corners, ids, _ = detector.detectMarkers(copy)
        if ids is not None and min(cv2.arcLength(c, True) / 4 for c in corners) >= _LARGE:
            return ids.ravel(), (np.reshape(corners, (-1, 4, 2)) + 0.5) * part - 0.5
    corners, ids, _ = detector.detectMarkers(cv2.GaussianBlur(grey, (0, 0), _BLUR))
    if ids is None:
        return np.empty(0, int), np.empty((0, 4, 2))
    return ids.ravel(), np.reshape(corners, (-1, 4, 2)).astype(np.float64)


def _arranged(ids, corners, border):
    """:class:`Tags` of detected ones, or None."""
    pairs = _adjacent(corners)
    votes = [Counter(int(ids[b] - ids[a]) for a, b, way in pairs if way == k) for k in range(4)]
    right = max(range(4), key=lambda k: votes[k][1] + votes[(k + 2) % 4][-1])
    if not votes[right][1] + votes[(right + 2) % 4][-1]:
        return None
    down = (right + 1) % 4
    steps = votes[down] + Counter({-step: n for step, n in votes[(down + 2) % 4].items()})
    step = steps.most_common(1)[0][0] if steps else None
    expected = {right: 1, (right + 2) % 4: -1}
    if step:
        expected |= {down: step, (down + 2) % 4: -step}
    fits = [(a, b) for a, b, way in pairs if expected.get(way) == ids[b] - ids[a]]
    keep = _largest_group(len(ids), fits)
    if len(keep) < _ENOUGH:
        return None
    return Tags(ids[keep], np.roll(corners[keep], -right, axis=1), abs(step) if step else None,
                not step or step < 0, right, border, len(ids) - len(keep))


def _adjacent(corners):
    """(a, b, way) of tags next to each other: ``b`` lies to the right of ``a`` (0), below it (1),
    to the left (2) or above it (3), as OpenCV's picture of the tag ``a`` stands."""
    middle = corners.mean(axis=1)
    across = (corners[:, 1] + corners[:, 2] - corners[:, 0] - corners[:, 3]) / 2
    down = (corners[:, 2] + corners[:, 3] - corners[:, 0] - corners[:, 1]) / 2
    found = []
    for a in range(len(corners)):
        matrix = np.stack([across[a], down[a]], axis=1)
        if abs(np.linalg.det(matrix)) < 1:
            continue
        at = np.linalg.solve(matrix, (middle - middle[a]).T).T
        for way, (axis, sign) in enumerate(((0, 1), (1, 1), (0, -1), (1, -1))):
            along, aside = sign * at[:, axis], np.abs(at[:, 1 - axis])
            next_ones = (along > _NEAR[0]) & (along < _NEAR[1]) & (aside < _ASIDE)
            if next_ones.any():
                found.append((a, int(np.where(next_ones, along, np.inf).argmin()), way))
    return found


def _largest_group(count, pairs):
    """Numbers of the largest group of ``count`` things that ``pairs`` join."""
    group = np.arange(count)
    for a, b in pairs:
        group[group == group[a]] = group[b]
    return np.flatnonzero(group == np.bincount(group).argmax())
