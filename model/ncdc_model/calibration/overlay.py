"""Draws the numbered points over the photo, so that a wrong number is seen at a glance."""

import cv2
import numpy as np

__all__ = ["draw_points"]

_SHIFT = 4             # fraction bits of OpenCV's drawing coordinates


def draw_points(image, photo):
    """RGB uint8 picture of ``image`` with ``photo``'s points and the lines of their lattice.

    Neighbours in a row are joined by a line whose colour tells the row, neighbours in a column
    likewise; a line that crosses others shows a wrong number. Every point has a dot, point
    (0, 0) a ring, and its number is written at every fifth where there is room.
    """
    # The photo recedes behind the drawing.
    picture = np.array(image if image.ndim == 3 else np.dstack([image] * 3))
    picture = (96 + 0.6 * picture).astype(np.uint8)
    scale = max(1.0, picture.shape[1] / 1280)
    thick = max(1, round(scale))
    place = {tuple(key): point for key, point in zip(photo.index.tolist(), photo.xy)}

    def fixed(point):
        return tuple(int(round(value * (1 << _SHIFT))) for value in point)
    for (i, j), point in place.items():
        for key, number in (((i + 1, j), j), ((i, j + 1), i)):
            if key in place:
                cv2.line(picture, fixed(point), fixed(place[key]), _colour(number), thick,
                         cv2.LINE_AA, _SHIFT)
    for (i, j), point in place.items():
        cv2.circle(picture, fixed(point), fixed([1.5 * scale])[0], (200, 0, 0), -1, cv2.LINE_AA,
                   _SHIFT)
        if i % 5 == 0 and j % 5 == 0:
            x, y = (int(round(value + 3 * scale)) for value in point)
            cv2.putText(picture, f"{i},{j}", (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.33 * scale,
                        (0, 0, 0), thick, cv2.LINE_AA)
    if (0, 0) in place:
        cv2.circle(picture, fixed(place[0, 0]), fixed([5 * scale])[0], (200, 0, 0), thick,
                   cv2.LINE_AA, _SHIFT)
    return picture


def _colour(number):
    """One of six well separated colours, by turns."""
    return ((214, 39, 40), (31, 119, 180), (44, 160, 44), (148, 60, 189), (200, 120, 0),
            (0, 150, 160))[number % 6]
