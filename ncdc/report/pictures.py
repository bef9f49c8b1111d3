"""Pictures for people: side by side, with captions and with straight lines to judge by."""

import cv2
import numpy as np

__all__ = ["draw_lines", "side_by_side"]

_BAR = 26              # pixels, height of a caption
_GAP = 6


def side_by_side(rows):
    """One picture of ``rows``, each a list of (caption, RGB picture) of one height."""
    strips = []
    for row in rows:
        cells = []
        for caption, picture in row:
            bar = np.full((_BAR, picture.shape[1], 3), 255, np.uint8)
            cv2.putText(bar, caption, (4, _BAR - 8), cv2.FONT_HERSHEY_SIMPLEX, 0.5, (30, 30, 30), 1,
                        cv2.LINE_AA)
            gap = np.full((_BAR + len(picture), _GAP, 3), 255, np.uint8)
            cells += [np.vstack([bar, picture]), gap]
        strips.append(np.hstack(cells[:-1]))
    width = max(strip.shape[1] for strip in strips)
    return np.vstack([np.pad(s, ((0, _GAP), (0, width - s.shape[1]), (0, 0)), constant_values=255)
                      for s in strips])


def draw_lines(picture, xy, index):
    """``picture`` (RGB) with the straight line that fits each row and column of points best.

    ``xy`` (n, 2) pixels, ``index`` (n, 2) column and row; lines of fewer than three points are
    left out.
    """
    result = np.ascontiguousarray(picture)
    for axis, colour in ((1, (220, 30, 30)), (0, (30, 90, 220))):
        for number in np.unique(index[:, axis]):
            points = xy[index[:, axis] == number]
            if len(points) < 3:
                continue
            middle = points.mean(axis=0)
            direction = np.linalg.svd(points - middle)[2][0]
            along = (points - middle) @ direction
            ends = [np.round((middle + t * direction) * 16).astype(int).tolist()
                    for t in (along.min(), along.max())]
            cv2.line(result, *ends, colour, 1, cv2.LINE_AA, 4)
    return result
