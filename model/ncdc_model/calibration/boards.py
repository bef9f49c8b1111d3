"""Finds chessboards with OpenCV."""

import cv2
import numpy as np

from ncdc_model.calibration.blobs import flat_field
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.errors import InputError

__all__ = ["find_any_chessboard", "find_chessboard", "grey_picture"]

_SQUARES = ((3, 3), (4, 3), (6, 4), (9, 6))   # inner corners that a board of unknown size may have


def find_chessboard(image, columns, rows):
    """Inner corners of a chessboard, ``columns`` x ``rows``, as PhotoPoints.

    Raises
    ------
    InputError
        If the whole board is not found.
    """
    for side, count in (("columns", columns), ("rows", rows)):
        if count < 3:
            raise InputError(f"the chessboard has {count} {side} of inner corners, at least 3 "
                             f"are needed")
    grey = grey_picture(image)
    flags = cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_ACCURACY
    for effort in (0, cv2.CALIB_CB_EXHAUSTIVE):
        found, corners = cv2.findChessboardCornersSB(grey, (columns, rows), flags=flags | effort)
        if found:
            return _points(corners, columns, rows)
    found, corners = cv2.findChessboardCorners(
        grey, (columns, rows), flags=cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE)
    if not found:
        raise InputError(f"no chessboard of {columns}x{rows} inner corners was found")
    grid = corners.reshape(rows, columns, 2)
    closest = min(np.linalg.norm(np.diff(grid, axis=axis), axis=2).min() for axis in (0, 1))
    half = int(np.clip(closest / 3, 2, 11))
    stop = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_COUNT, 50, 1e-3)
    return _points(cv2.cornerSubPix(grey, corners, (half, half), (-1, -1), stop), columns, rows)


def find_any_chessboard(image):
    """Columns and rows of the inner corners of a chessboard whose size is not known.

    Raises
    ------
    InputError
        If no board of at least 3x3 inner corners is found.
    """
    grey, best = grey_picture(image), None
    for columns, rows in _SQUARES:
        found, _, meta = cv2.findChessboardCornersSBWithMeta(
            grey, (columns, rows), cv2.CALIB_CB_NORMALIZE_IMAGE | cv2.CALIB_CB_LARGER)
        if found and (best is None or meta.size > best[0] * best[1]):
            best = meta.shape[1], meta.shape[0]
    if best is None:
        raise InputError("no chessboard was found")
    return best


def grey_picture(image):
    """Eight-bit grey picture; a raw frame is made grey by flat-fielding each filter colour."""
    if image.ndim == 3:
        return cv2.cvtColor(image, cv2.COLOR_RGB2GRAY)
    return np.clip(110 * flat_field(image), 0, 255).astype(np.uint8)


def _points(found, columns, rows):
    """PhotoPoints of a grid found in order, turned by half a turn if its last point comes first.

    Half a turn, not a flip: the target must not be seen as if from behind.
    """
    grid = np.asarray(found, np.float64).reshape(rows, columns, 2)
    if (grid[-1, -1] - grid[0, 0]).sum() < 0:
        grid = grid[::-1, ::-1]
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    return PhotoPoints(index=np.stack([i.ravel(), j.ravel()], axis=1), xy=grid.reshape(-1, 2),
                       area=np.zeros(columns * rows))
