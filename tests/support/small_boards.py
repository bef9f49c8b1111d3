"""Small photos of boards through lenses that are exactly equidistant."""

from dataclasses import dataclass

import numpy as np

from ncdc_bench.truth.boards import Board, photograph_board

__all__ = ["SIZE", "Equidistant", "board_photo"]

SIZE = 640, 480


@dataclass(frozen=True)
class Equidistant:
    """A lens of so many ``degrees`` from left to right, its picture ``scale`` times as large."""
    degrees: float
    scale: float = 1.0

    @property
    def _focal(self):
        return self.scale * SIZE[0] / np.radians(self.degrees)

    @property
    def _centre(self):
        return np.array([SIZE[0] / 2 + 1.3, SIZE[1] / 2 - 2.1])

    def project(self, rays):
        """Pixels (n, 2) of directions (n, 3)."""
        across = np.hypot(rays[:, 0], rays[:, 1])
        theta = np.arctan2(across, rays[:, 2]) / np.maximum(across, 1e-12)
        return self._focal * rays[:, :2] * theta[:, None] + self._centre

    def angles(self, columns, rows):
        """Directions (2, n, m) as angle times unit vector."""
        x, y = self._centre
        return np.stack(np.meshgrid((columns - x) / self._focal, (rows - y) / self._focal))


def board_photo(kind, columns, rows, lens, reach, turns=(4.0, -5.0, 7.0), seed=0):
    """Photo of a board whose sides lie ``reach`` degrees from the axis."""
    wide = Board(kind, columns, rows, 1.0, turns).corners[1][:, 0]
    half = (np.ptp(wide) + 2) / 2
    board = Board(kind, columns, rows, half / np.tan(np.radians(reach)), turns)
    return photograph_board(lens, board, seed, SIZE)
