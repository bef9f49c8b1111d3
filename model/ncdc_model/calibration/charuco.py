"""Finds ChArUco boards: chessboards whose white squares carry numbered markers."""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_model.calibration.boards import examined, find_boards, grey_picture, within
from ncdc_model.calibration.outliers import without_outliers
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.calibration.predicted import completed
from ncdc_model.calibration.sampling import sample
from ncdc_model.nearest import Nearest
from ncdc_spec.errors import InputError

__all__ = ["find_any_charuco", "find_charuco", "has_markers", "sees_markers"]

# The largest dictionary of each family includes the smaller ones.
_FAMILIES = ("DICT_4X4_1000", "DICT_5X5_1000", "DICT_6X6_1000", "DICT_7X7_1000",
             "DICT_ARUCO_ORIGINAL", "DICT_APRILTAG_36h11")
_MARKERS = 4           # of a board, at least
_CORNERS = 12
_SCALE = 2.0           # pixels: blur at which OpenCV finds corners
_RIMS = 0.38, 0.5, 0.62, 0.74   # of the distance from a square's middle to its side
_PLAIN = 0.25          # of a chessboard's squares are bright, at least; half of a whole board's
_AGREEING = 4          # corners whose marker numbers agree with the lattice, at least
_SAME = 0.15           # of a step: largest distance of OpenCV's corner from the lattice's
_SIDES = range(3, 25)  # squares that a board of unknown size may have in a row
_COPY = 1600           # pixels of the longer side: of a larger photo a copy is searched
_LARGE = 20            # pixels: of markers that large none is missed there
# Codes of a family that are compared with each quadrangle. A board has numbers from 0 on, so that
# more are compared only if the numbers found come near their end.
_CODES = 50, 250, 1024
_SURE = 12, 0.2        # markers, and parts of the quadrangles: no other family can have more
_NEAR_END = 0.8


def find_charuco(image, columns, rows, lattices=None):
    """Inner corners of a board of ``columns`` x ``rows`` squares, as far as they are seen.

    The family of the markers and their size are read from the picture. OpenCV numbers corners by
    the markers next to them, so that part of a board has the numbers of the whole one. If some are
    missing, the corners are those of the lattice of squares, which must have the same numbers up to
    a rotation. The picture is smoothed so little that no marker enters the surroundings of a
    corner; a corner that cannot be found so is left out.

    Parameters
    ----------
    image : ndarray of uint8
    columns, rows : int
        Squares.
    lattices : callable, optional
        Gives :func:`ncdc_model.calibration.corners.find_corner_lattices` of the picture, if known.

    Raises
    ------
    InputError
        If fewer than 12 corners are found, or markers of a larger board.
    """
    grey = grey_picture(image)
    copy, part, (family, corners, ids) = _markers(grey, columns * rows)
    foreign = ids[ids >= columns * rows // 2]
    if len(foreign) > 1:
        raise InputError(f"it shows markers up to number {int(ids.max())}, a ChArUco board of "
                         f"{columns}x{rows} squares has {columns * rows // 2} from 0")
    found = _corners(copy, family, corners, ids, columns, rows) if family else (None, None)
    photo = None
    if found[0] is not None and len(found[0]):
        index = np.stack([found[1] % (columns - 1), found[1] // (columns - 1)], axis=1)
        size, margin = (columns - 1, rows - 1), (1 - _marker_size(corners, ids)) / 2
        index, xy = within(margin, grey, index, (found[0] + 0.5) * part - 0.5, _SCALE * part)
        if len(xy) == np.prod(size):
            photo = _whole(image, grey, index, xy)
        elif len(xy):
            boards = find_boards(image, lattices() if lattices else None, margin)
            photo = _numbered(image, index, xy, size, boards)
            photo = photo and _with_missed(image, grey, photo, size, margin)
    count = 0 if photo is None else len(photo.index)
    if count < _CORNERS:
        raise InputError(f"{count} corners of a ChArUco board of {columns}x{rows} squares were "
                         f"found, at least {_CORNERS} are needed")
    return photo


def _with_missed(image, grey, photo, size, margin):
    """``photo`` with the corners that neither OpenCV nor the lattice had, where a lens predicts
    them."""
    every = np.stack(np.meshgrid(*map(np.arange, size)), axis=-1).reshape(-1, 2)
    index, xy = completed(grey, (photo.index, photo.xy), every, np.float64, margin)
    return photo if len(xy) == len(photo.xy) else _completed(image, photo, index, xy)


def _whole(image, grey, index, xy):
    """PhotoPoints of all corners of a board, without outliers."""
    order = np.lexsort(index.T)
    photo = PhotoPoints(index=index[order], xy=xy[order], area=np.zeros(len(xy)))
    return examined(image, grey, _renumbered_checked(image, photo))


def _numbered(image, index, xy, size, boards):
    """PhotoPoints of the board's ``index`` and ``xy`` by markers, on the lattice that agrees best.

    The result is None if a lattice is seen and the markers' numbers are not those of its corners.
    """
    best, votes, met = None, 0, 0
    for board in boards:
        away, nearest = (part[:, 0] for part in Nearest(board.xy).query(xy))
        same = away < _SAME * _step(board)
        if same.sum() < _AGREEING:
            continue
        turned, agree = _renumbered(board.index, board.index[nearest[same]], index[same])
        if agree > votes:
            inside = ((turned >= 0) & (turned < size)).all(axis=1)
            best, votes = replace(board, index=turned[inside], xy=board.xy[inside],
                                  area=board.area[inside], cut=board.cut[inside]), agree
            met = int(same.sum())
    if best is None:
        if boards and len(boards[0].index) >= len(index):
            return None
        best = PhotoPoints(index=index, xy=xy, area=np.zeros(len(xy)))
        return _renumbered_checked(image, best)
    if votes < _AGREEING or votes < met / 2:
        return None
    return _completed(image, best, index, xy)


def _renumbered_checked(image, photo):
    """``photo`` without outliers, with the markers' numbers, which need not begin at 0."""
    number = {tuple(position): key for position, key in zip(photo.xy.tolist(), photo.index)}
    held = without_outliers(image.shape[1::-1], photo)
    return replace(held, index=np.array([number[tuple(position)] for position in held.xy.tolist()],
                                        int).reshape(-1, 2))


def _completed(image, board, index, xy):
    """``board`` with those of OpenCV's corners that its lattice lacks, outliers excepted."""
    there = set(map(tuple, board.index.tolist()))
    more = [k for k, key in enumerate(index.tolist()) if tuple(key) not in there]
    if more:
        every = PhotoPoints(index=np.vstack([board.index, index[more]]),
                            xy=np.vstack([board.xy, xy[more]]),
                            area=np.zeros(len(board.index) + len(more)), dropped=board.dropped,
                            rejected=board.rejected, warnings=board.warnings)
        board = _renumbered_checked(image, every)
    order = np.lexsort(board.index.T)
    return replace(board, index=board.index[order], xy=board.xy[order], area=board.area[order],
                   cut=board.cut[order])


def _step(board):
    """Distance of neighbouring corners, pixels."""
    distance, _ = Nearest(board.xy).query(board.xy, 2)
    return float(np.median(distance[:, 1]))


def _renumbered(index, seen, wanted):
    """``index`` turned and shifted so that most of ``seen`` become ``wanted``, and their number."""
    best = index, 0
    for turn in (np.array([[1, 0], [0, 1]]), np.array([[0, 1], [-1, 0]]),
                 np.array([[-1, 0], [0, -1]]), np.array([[0, -1], [1, 0]])):
        shifts, counts = np.unique(wanted - seen @ turn, axis=0, return_counts=True)
        if counts.max() > best[1]:
            best = index @ turn + shifts[counts.argmax()], int(counts.max())
    return best


def has_markers(image, board):
    """Whether the white squares of ``board``, PhotoPoints of a chessboard in ``image``, carry
    markers: a marker's border is black, so that few squares are bright near their sides."""
    grey = grey_picture(image)
    position = {tuple(k): p for k, p in zip(board.index.tolist(), board.xy)}
    spots = []
    for i, j in position:
        corners = [position.get(key) for key in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1))]
        if all(corner is not None for corner in corners):
            middle, sides = sum(corners) / 4, zip(corners, corners[1:] + corners[:1])
            # A marker of 0.4 to 0.9 of a square has its border at one of these positions.
            spots.append([middle + part * ((a + b) / 2 - middle) for a, b in sides
                          for part in _RIMS])
    if not spots:
        return False
    values = sample(grey, spots)
    low, high = np.percentile(values, (5, 95))
    darkest = values.reshape(len(values), 4, len(_RIMS)).min(axis=2)
    return bool((np.median(darkest, axis=1) > (low + high) / 2).mean() < _PLAIN)


def sees_markers(grey):
    """Whether a grey picture shows some of the first markers of a family."""
    return _most(grey, _FAMILIES, _CODES[0])[0] is not None


def find_any_charuco(image):
    """Columns and rows of the squares of a board whose size is not known.

    The rows are those up to the highest marker that is seen.

    Raises
    ------
    InputError
        If the picture shows no board.
    """
    grey, _, (family, corners, ids) = _markers(grey_picture(image))
    best = None
    for columns in _SIDES if family else ():
        rows = -(-2 * (int(ids.max()) + 1) // columns)
        if 3 <= rows <= 200 and columns * rows // 2 <= len(_dictionary(family).bytesList):
            xy, _ = _corners(grey, family, corners, ids, columns, rows)
            count = 0 if xy is None else len(xy)
            if count >= _CORNERS and (best is None or count > best[0]):
                best = count, columns, rows
    if best is None:
        raise InputError("no ChArUco board was found")
    return best[1:]


def _dictionary(family, count=_CODES[-1]):
    """The first ``count`` codes of a family."""
    whole = cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, family))
    return cv2.aruco.Dictionary(whole.bytesList[:count], whole.markerSize, whole.maxCorrectionBits)


def _markers(grey, codes=_CODES[0]):
    """The picture in which markers are found best, how many pixels of ``grey`` one of its pixels
    is wide, and the family, corners and numbers of the markers.

    That is a reduced copy, unless the markers there are so small that others may be missed.
    ``codes``: of a family that are compared first.
    """
    part = -(-max(grey.shape) // _COPY)
    if part > 1:
        copy = cv2.resize(grey[:grey.shape[0] // part * part, :grey.shape[1] // part * part], None,
                          fx=1 / part, fy=1 / part, interpolation=cv2.INTER_AREA)
        family, corners, _ = found = _seen(copy, codes)
        if family and min(cv2.arcLength(corner, True) / 4 for corner in corners) >= _LARGE:
            return copy, part, found
    return grey, 1, _seen(grey, codes)


def _seen(grey, codes):
    """Family, corners and numbers of the markers of the family of which most are seen."""
    found, fewer = _most(grey, _FAMILIES, codes), codes
    for count in _CODES:
        if count > fewer and not (found[0] and found[2].max() < _NEAR_END * fewer):
            found, fewer = _most(grey, (found[0],) if found[0] else _FAMILIES, count), count
    return found


def _most(grey, families, count):
    """:func:`_seen` of some ``families``, by the first ``count`` codes of each."""
    best = None, (), np.empty(0, int)
    for family in families:
        corners, ids, rejected = cv2.aruco.ArucoDetector(_dictionary(family, count)).detectMarkers(
            grey)
        if ids is not None and len(ids) >= max(_MARKERS, len(best[2]) + 1):
            best = family, corners, ids.ravel()
            if len(ids) >= max(_SURE[0], _SURE[1] * (len(ids) + len(rejected))):
                break
    return best


def _corners(grey, family, corners, ids, columns, rows):
    """Positions (n, 2) and numbers (n,) of the inner corners, or (None, None)."""
    best = None, None
    for old in (False, True):
        board = cv2.aruco.CharucoBoard((columns, rows), 1.0, _marker_size(corners, ids),
                                       _dictionary(family))
        board.setLegacyPattern(old)
        known = ids < len(board.getIds())
        if known.sum() < _MARKERS:
            continue
        xy, number, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(
            grey, markerCorners=[c for c, use in zip(corners, known) if use],
            markerIds=ids[known].reshape(-1, 1).astype(np.int32))
        if number is not None and (best[0] is None or len(number) > len(best[0])):
            best = np.asarray(xy, np.float64).reshape(-1, 2), np.asarray(number, int).ravel()
    return best


def _marker_size(corners, ids):
    """Side of a marker in squares: markers with consecutive numbers are two squares apart."""
    position = {int(number): corner.reshape(4, 2) for number, corner in zip(ids, corners)}
    sizes = []
    for number, corner in position.items():
        if number + 1 in position:
            apart = np.linalg.norm(position[number + 1].mean(axis=0) - corner.mean(axis=0)) / 2
            side = np.mean(np.linalg.norm(corner - np.roll(corner, 1, axis=0), axis=1))
            sizes.append(side / apart)
    return float(np.clip(np.median(sizes), 0.2, 0.95)) if sizes else 0.75
