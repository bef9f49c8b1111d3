"""Finds chessboards, whole or in part, several in one photo, of known size or not."""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_model.calibration.blobs import flat_field
from ncdc_model.calibration.corners import check_squares, find_corner_lattices
from ncdc_model.calibration.exposure import with_exposure
from ncdc_model.calibration.focus import with_focus
from ncdc_model.calibration.outliers import location_text, without_outliers
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.calibration.subpixel import gaps, refine
from ncdc_spec.errors import InputError

__all__ = ["board_of_size", "examined", "find_boards", "find_chessboard", "grey_picture", "within"]

_ENOUGH = 12           # corners of a part of a board
_SCALE = 2.0           # pixels: blur at which OpenCV finds corners
_LARGEST = 1 << 21     # pixels of a picture that OpenCV searches: it takes 200 bytes for each
_GREY = 110            # of a raw frame's mean brightness
_WHITE, _SAMPLED = 99, 7        # percentile that is white, and pixels between those counted
_COPY = 1_500_000      # pixels of the copy that it searches of a larger one


def find_boards(image, lattices=None, margin=None):
    """All chessboards in the picture, PhotoPoints each, the one with most corners first.

    i grows to the right and j downwards; the smallest of each is 0. ``lattices``: result of
    :func:`ncdc_model.calibration.corners.find_corner_lattices` for the picture, if known.
    ``margin``: parts of a square around its markers, if it has some; corners that cannot be found
    within it are left out.
    """
    grey, boards = grey_picture(image), []
    for board in find_corner_lattices(grey) if lattices is None else lattices:
        index, xy = board.index, board.xy
        if margin is not None:
            index, xy = within(margin, grey, index, xy, board.scale)
        try:
            boards.append(examined(image, grey, _without_outliers(image, index, xy)))
        except InputError:
            pass
    boards = [board for board in boards if len(board.index) >= 9]
    return sorted(boards, key=lambda board: -len(board.index))


def within(margin, grey, index, xy, scale):
    """``index`` and ``xy`` (n, 2) of the corners that :func:`refine` finds by no more than the
    ``margin`` around markers."""
    moved = refine(grey, index, xy, scale, margin * gaps(index, xy))
    found = np.isfinite(moved).all(axis=1)
    return index[found], moved[found]


def find_chessboard(image, columns, rows):
    """Inner corners of a chessboard, ``columns`` x ``rows``, as PhotoPoints; or of a part.

    Raises
    ------
    InputError
        If no such board, no 12 corners of one, or a larger one is found.
    """
    return board_of_size(find_boards(image), columns, rows, lambda: image)


def board_of_size(boards, columns, rows, image):
    """The one of ``boards`` of :func:`find_boards` that is ``columns`` x ``rows`` or a part.

    If none is whole, OpenCV also searches the result of ``image()``, which takes more time.
    Raises :class:`InputError` as :func:`find_chessboard`.
    """
    for side, count in (("columns", columns), ("rows", rows)):
        if count < 3:
            raise InputError(f"the chessboard has {count} {side} of inner corners, at least 3 "
                             f"are needed")
    fitting = [board for board in boards if _fits(board, columns, rows)]
    larger = [board for board in boards if not _fits(board, columns, rows)]
    if larger and (not fitting or len(larger[0].index) > 2 * len(fitting[0].index)):
        across, down = sorted(np.ptp(larger[0].index, axis=0) + 1, reverse=True)
        raise InputError(f"it shows a chessboard of at least {across}x{down} inner corners, not of "
                         f"{columns}x{rows}")
    whole = [board for board in fitting if len(board.index) == columns * rows]
    if not whole:
        other = _by_opencv(image(), columns, rows)
        if other is not None and len(other.index) > len(fitting[0].index if fitting else ()):
            whole = [other]
    best = (whole or fitting or [None])[0]
    if best is None or len(best.index) < _ENOUGH:
        if best is None:
            raise InputError(f"no chessboard of {columns}x{rows} inner corners was found")
        raise InputError(f"{len(best.index)} corners of a chessboard were found, at least "
                         f"{_ENOUGH} are needed")
    others = [board for board in boards if not _overlap(board, best)]
    return _turned(replace(best, remarks=tuple(
        f"another chessboard, {len(board.index)} corners {location_text(board)}, is not used"
        for board in others)), columns, rows)


def grey_picture(image):
    """Eight-bit grey picture; a raw frame is made grey by flat-fielding each filter colour."""
    if image.ndim == 3:
        return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    flat = flat_field(image)
    # White on a dark wall is over twice as bright as its surroundings: it must not be cut off.
    flat *= min(_GREY, 255 / max(float(np.percentile(flat[::_SAMPLED, ::_SAMPLED], _WHITE)), 1))
    return np.clip(flat, 0, 255, out=flat).astype(np.uint8)


def _without_outliers(image, index, xy):
    order = np.lexsort(index.T)
    return without_outliers(image.shape[1::-1], PhotoPoints(index=index[order], xy=xy[order],
                                                    area=np.zeros(len(xy))))


def examined(image, grey, board):
    """``board`` with warnings on focus and exposure."""
    return with_exposure(image, with_focus(grey, board))


def _fits(board, columns, rows):
    across, down = np.ptp(board.index, axis=0) + 1
    return (across <= columns and down <= rows) or (across <= rows and down <= columns)


def _overlap(first, second):
    """Whether two boards are the same: the middle of one lies within the other."""
    middle = first.xy.mean(axis=0)
    return bool(((middle > second.xy.min(axis=0)) & (middle < second.xy.max(axis=0))).all())


def _turned(board, columns, rows):
    """``board``, turned by a quarter if it only fits so; it is not reflected."""
    across, down = np.ptp(board.index, axis=0) + 1
    index = board.index
    if not (across <= columns and down <= rows):
        index = np.stack([index[:, 1], -index[:, 0]], axis=1)
        index = index - index.min(axis=0)
        # Of the two quarter turns take the one whose first point lies further to the top left.
        first, last = (index.sum(axis=1) == value for value in
                       (index.sum(axis=1).min(), index.sum(axis=1).max()))
        if board.xy[first].sum(axis=1).mean() > board.xy[last].sum(axis=1).mean():
            index = index.max(axis=0) - index
    order = np.lexsort(index.T)
    return replace(board, index=index[order], xy=board.xy[order], area=board.area[order],
                   cut=board.cut[order])


def _by_opencv(image, columns, rows):
    """OpenCV's corners, if they pass the check of squares, without outliers; else None.

    OpenCV has found corners far outside the board at the edge of a fisheye picture. A picture of
    more than two million pixels is searched in a smaller copy.
    """
    grey = whole = grey_picture(image)
    scale = 1.0, 1.0
    if grey.size > _LARGEST:
        full, shrink = np.array(grey.shape[::-1]), np.sqrt(_COPY / grey.size)
        grey = cv2.resize(grey, np.rint(shrink * full).astype(int), interpolation=cv2.INTER_AREA)
        scale = full / grey.shape[::-1]
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    for effort in (0, cv2.CALIB_CB_EXHAUSTIVE):
        found, corners = cv2.findChessboardCornersSB(grey, (columns, rows), flags=flags | effort)
        if found:
            break
    else:
        return None
    grid = np.asarray(corners, np.float64).reshape(rows, columns, 2)
    if (grid[-1, -1] - grid[0, 0]).sum() < 0:
        grid = grid[::-1, ::-1]
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    index, xy = np.stack([i.ravel(), j.ravel()], axis=1), grid.reshape(-1, 2)
    if not check_squares(cv2.GaussianBlur(grey, (0, 0), 1).astype(np.float32), index, xy).all():
        return None
    try:
        xy = refine(whole, index, (xy + 0.5) * scale - 0.5, _SCALE * max(scale))
        return examined(image, whole, _without_outliers(image, index, xy))
    except InputError:
        return None
