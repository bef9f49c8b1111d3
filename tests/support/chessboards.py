"""Pictures of chessboards, drawn."""

import numpy as np

__all__ = ["chessboard"]


def chessboard(columns, rows, step=40, light=(230, 230, 230)):
    """Picture of a board with ``columns`` x ``rows`` inner corners, black 20 on ``light``, a colour
    or a level of grey; the coordinate, on both axes, of its first corner."""
    y, x = np.mgrid[:(rows + 3) * step, :(columns + 3) * step]
    i, j = x // step - 1, y // step - 1
    black = (i >= 0) & (i <= columns) & (j >= 0) & (j <= rows) & ((i + j) % 2 == 0)
    black = black[:, :, None] if np.ndim(light) else black
    return np.where(black, 20, np.array(light)).astype(np.uint8), 2 * step - 0.5
