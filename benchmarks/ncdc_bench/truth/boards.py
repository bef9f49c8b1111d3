"""Photos of flat boards of squares and markers through a :class:`TrueLens`."""

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from scipy.spatial.transform import Rotation

from ncdc_bench.photos.targets import Photo, Truth
from ncdc_bench.truth.lenses import SIZE
from ncdc_bench.truth.render import expose

__all__ = ["BOARDS", "POSES", "SPACING", "Board", "board_of", "photograph_board"]

BOARDS = {"chessboard": (17, 12), "charuco": (18, 13), "aprilgrid": (8, 6)}
"""Kinds of board, and columns and rows as ``ncdc calibrate --target`` counts them."""
SPACING = 0.3          # of an AprilGrid: gap between two tags, in sides of a tag

# One photo; five more from other sides.
POSES = ((3.0, -4.0, 5.0), (-16.0, 8.0, -4.0), (10.0, 18.0, 88.0), (14.0, -15.0, 176.0),
         (-6.0, -20.0, -94.0), (20.0, 5.0, 12.0))
_WIDEST = 64.0         # degrees from the axis that the board's sides reach, at most
_FILLED = 0.97         # of the picture's width, of a lens that is less wide
_PAPER = 0.4           # squares: white around the board
_BEHIND = 0.7          # share of black of the wall behind it
_MARGIN = 2.0          # pixels from the border: a corner closer to it is not counted as seen
_ACROSS = 12.0         # pixels between a corner and the nearest: with fewer it is not counted
_MARKERS = 8           # texels of a ChArUco board's square: one for each cell of its markers
_SLANT = 0.25          # of the grid of samples: edges along it would be a quarter of a pixel coarse
_CELLS = 10            # cells of Kalibr's tags, the border of two included


@dataclass(frozen=True)
class Board:
    """A flat board in front of the camera.

    Parameters
    ----------
    kind : str
        One of :data:`BOARDS`.
    columns, rows : int
        As ``ncdc calibrate --target`` counts them.
    distance : float
        From the lens to the middle of the board, in squares, or tags.
    turns : (float, float, float)
        Rotation vector of the board in degrees.
    """
    kind: str
    columns: int
    rows: int
    distance: float
    turns: tuple

    @cached_property
    def texture(self):
        """Where the board is black, its texels in one unit, and the unit of its upper left end.

        The unit is a square, or a tag. Its origin is the first corner.
        """
        if self.kind == "chessboard":
            j, i = np.indices((self.rows + 1, self.columns + 1))
            return (i + j) % 2 == 0, 1, -1.0
        if self.kind == "charuco":
            board = cv2.aruco.CharucoBoard((self.columns, self.rows), 1.0, 0.75,
                                           _family("4X4_1000"))
            size = self.columns * _MARKERS, self.rows * _MARKERS
            return board.generateImage(size) == 0, _MARKERS, -1.0
        return self._april(), _CELLS, -SPACING

    def _april(self):
        """Kalibr's AprilGrid: tag 0 at the lower left end, black squares between the tags."""
        gap = round(SPACING * _CELLS)
        period, family = _CELLS + gap, _family("APRILTAG_36h11")
        black = np.zeros((self.rows * period + gap, self.columns * period + gap), bool)
        for j in range(self.rows + 1):
            for i in range(self.columns + 1):
                black[j * period:j * period + gap, i * period:i * period + gap] = True
        for number in range(self.rows * self.columns):
            row, column = divmod(number, self.columns)
            top, left = (self.rows - 1 - row) * period + gap, column * period + gap
            # OpenCV's picture of a tag stands on its head, compared with Kalibr's.
            tag = cv2.aruco.generateImageMarker(family, number, _CELLS, borderBits=2)[::-1, ::-1]
            black[top:top + _CELLS, left:left + _CELLS] = tag == 0
        return black

    @cached_property
    def corners(self):
        """Index (n, 2) of all corners, and their places (n, 2) in units."""
        columns, rows = {"charuco": (self.columns - 1, self.rows - 1),
                         "aprilgrid": (2 * self.columns, 2 * self.rows)}.get(
                             self.kind, (self.columns, self.rows))
        i, j = np.meshgrid(np.arange(columns), np.arange(rows))
        index = np.stack([i.ravel(), j.ravel()], axis=1)
        if self.kind == "aprilgrid":
            return index, index // 2 * (1 + SPACING) + index % 2
        return index, index.astype(float)

    @property
    def plane(self):
        """Matrix (3, 3) from (unit, unit, 1) to a direction."""
        turn = Rotation.from_rotvec(self.turns, degrees=True).as_matrix()
        places = self.corners[1]
        middle = (places.min(axis=0) + places.max(axis=0)) / 2
        return np.column_stack([turn[:, 0], turn[:, 1],
                                (0, 0, self.distance) - turn[:, :2] @ middle])

    def ink(self, angles):
        """Share of black that is seen in the directions ``angles`` (2, ...)."""
        theta = np.hypot(*angles)
        sine = np.sinc(theta / np.pi)
        ray = angles[0] * sine, angles[1] * sine, np.cos(theta)
        i, j, w = (row[0] * ray[0] + row[1] * ray[1] + row[2] * ray[2]
                   for row in np.linalg.inv(self.plane))
        black, texels, first = self.texture
        with np.errstate(divide="ignore", invalid="ignore"):
            at = [np.nan_to_num((part / w - first) * texels, nan=-1e9, posinf=1e9, neginf=-1e9)
                  for part in (i, j)]
        far, reach = black.shape[::-1], _PAPER * texels
        paper, on = w > 0, w > 0
        for part, side in zip(at, far):
            paper &= (part > -reach) & (part < side + reach)
            on = on & (part >= 0) & (part < side)
        column, row = (np.where(on, part, 0).astype(int) for part in at)
        return np.where(on, black[row, column], np.where(paper, 0.0, _BEHIND)).astype(np.float32)


def _family(name):
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, f"DICT_{name}"))


def board_of(lens, kind, number):
    """The :class:`Board` of ``kind`` in front of ``lens`` on photo ``number``."""
    edge = np.hypot(*lens.angles_at(np.array([[0.0, (SIZE[1] - 1) / 2]])).T).item()
    reach = _FILLED * np.tan(min(edge, np.radians(_WIDEST)))
    columns, rows = BOARDS[kind]
    half = {"chessboard": columns + 1, "charuco": columns,
            "aprilgrid": columns * (1 + SPACING) + SPACING}[kind] / 2
    return Board(kind, columns, rows, half / reach, POSES[number])


def photograph_board(lens, board, seed=0, size=SIZE):
    """:class:`Photo` of ``board`` through ``lens``.

    Its truth counts the corners that are 2 pixels inside of the picture and 12 pixels or more from
    the nearest corner of the board.
    """
    index, places = board.corners
    rays = np.column_stack([places, np.ones(len(places))]) @ board.plane.T
    xy = lens.project(rays)
    limit = np.array(size) - 1 - _MARGIN
    seen = (rays[:, 2] > 0) & ((xy > _MARGIN) & (xy < limit)).all(axis=1)
    near = np.linalg.norm(xy[:, None] - xy[None], axis=2)
    np.fill_diagonal(near, np.inf)
    seen &= near.min(axis=1) >= _ACROSS
    image = expose(lens, board.ink, seed, size, _SLANT)
    return Photo(image, (Truth(board.kind, index, xy, seen),))
