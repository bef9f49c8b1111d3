"""Draws the numbered points over the photo, to make a wrong number visible."""

from dataclasses import dataclass
from math import dist

import cv2
import numpy as np

__all__ = ["Backdrop", "draw_on", "draw_points"]

_WIDTH = 1280          # pixels: of a photo of twice that or more a reduced copy is drawn on
_SHIFT = 4             # fraction bits of OpenCV's drawing coordinates
_OUTSIDE = 0, 110, 200  # colour of the square around a point outside the frame
_ARROW = 0.4           # of the middle step between points: length of an arrow of the usual size
_MAGNIFY = 1, 2, 5, 10, 20, 50, 100, 200, 500


@dataclass(frozen=True)
class Backdrop:
    """A copy of a photo to draw on.

    Parameters
    ----------
    picture : ndarray of uint8, shape (height, width, 3)
        RGB, paler than the photo, so that the drawing stands out.
    part : int
        Pixels of the photo, in a row, that one of its pixels is the mean of.
    """
    picture: np.ndarray
    part: int

    @classmethod
    def of(cls, image):
        """Backdrop of a photo, uint8 (h, w) or (h, w, 3)."""
        part = 1 if image.shape[1] < 2 * _WIDTH else round(image.shape[1] / _WIDTH)
        if part > 1:
            image = cv2.resize(image, (image.shape[1] // part, image.shape[0] // part),
                               interpolation=cv2.INTER_AREA)
        picture = cv2.LUT(image, (96 + 0.6 * np.arange(256)).astype(np.uint8))
        return cls(picture if picture.ndim == 3 else cv2.cvtColor(picture, cv2.COLOR_GRAY2RGB),
                   part)


def draw_points(image, photo, frame=None, number=0):
    """:func:`draw_on` the :class:`Backdrop` of the photo ``image``."""
    return draw_on(Backdrop.of(image), photo, frame, number)


def draw_on(backdrop, photo, frame=None, number=0):
    """RGB uint8 picture of ``backdrop`` with ``photo``'s points and the lines of their lattice.

    A line joins the neighbours in a row, in a colour for the row, and likewise those in a column;
    a line that crosses others shows a wrong number. Every point has a dot, hollow where the border
    cuts it, point (0, 0) also a ring. Every fifth point of every fifth row has its number. With
    ``frame`` (the :class:`IdealFrame` of the photos, of which this is ``number``) an arrow leads
    from each point to the smooth lens's position, magnified as the text at the bottom says, dropped
    points are crossed out, and a square marks those outside the frame, which the lens explains.
    The picture of a photo of 2560 or more pixels a row is a half or another whole part of it wide.
    """
    picture, part = backdrop.picture.copy(), backdrop.part
    scale = max(1.0, picture.shape[1] / _WIDTH)
    thick = max(1, round(scale))
    position = dict(zip(map(tuple, photo.index.tolist()),
                        ((photo.xy + 0.5) / part - 0.5).tolist()))
    cut = {tuple(key) for key in photo.index[photo.cut].tolist()}

    def fixed(point):
        return tuple(round(value * (1 << _SHIFT)) for value in point)
    # Neighbours in a line of a staggered grid are two half steps away.
    step = 1 if len({sum(key) % 2 for key in position}) > 1 or len(position) < 2 else 2
    lengths = []
    for (i, j), point in position.items():
        for key, line in (((i + step, j), j), ((i, j + step), i)):
            if key in position:
                lengths.append(dist(position[key], point))
                cv2.line(picture, fixed(point), fixed(position[key]), _colour(line), thick,
                         cv2.LINE_AA, _SHIFT)
    for (i, j), point in position.items():
        cv2.circle(picture, fixed(point), *fixed([(2.5 if (i, j) in cut else 1.5) * scale]),
                   (200, 0, 0), thick if (i, j) in cut else -1, cv2.LINE_AA, _SHIFT)
        if i % 5 == 0 and j % 5 == 0:
            x, y = (int(round(value + 3 * scale)) for value in point)
            cv2.putText(picture, f"{i},{j}", (x, y), cv2.FONT_HERSHEY_SIMPLEX, 0.33 * scale,
                        (0, 0, 0), thick, cv2.LINE_AA)
    if (0, 0) in position:
        cv2.circle(picture, fixed(position[0, 0]), *fixed([5 * scale]), (200, 0, 0), thick,
                   cv2.LINE_AA, _SHIFT)
    if frame is not None and number in frame.numbers:
        step = float(np.median(lengths)) if lengths else 20.0
        _residuals(picture, photo, frame, number, position, step, part, fixed)
    return picture


def _residuals(picture, photo, frame, number, position, step, part, fixed):
    """Arrows from the used points to the smooth lens's positions; crosses over dropped ones,
    squares around those outside the frame.

    ``number``: of the photo. ``position`` and ``step`` are in pixels of the picture, ``part`` of
    the photo's each.
    """
    on = frame.photo == frame.numbers.index(number)
    residual = np.stack(frame.camera.back_map(*frame.corrected[on].T), axis=1) - frame.distorted[on]
    usual = float(np.sqrt(np.mean(residual**2) * 2)) if on.any() else 0.0
    wanted = _ARROW * step * part / max(usual, 1e-6)
    scale = max(1.0, picture.shape[1] / _WIDTH)
    magnify = max((value for value in _MAGNIFY if value <= wanted), default=_MAGNIFY[0])
    thick = max(1, round(scale))
    used = {tuple(key) for key in frame.index[on].tolist()}
    for key, (dx, dy) in zip(frame.index[on].tolist(), (magnify / part * residual).tolist()):
        x, y = position[tuple(key)]
        cv2.arrowedLine(picture, fixed((x, y)), fixed((x + dx, y + dy)), (0, 0, 0), thick,
                        cv2.LINE_AA, _SHIFT, 0.25)
    dropped = {tuple(key) for where, key in frame.gross if frame.numbers[where] == number}
    for key, (x, y) in position.items():
        if key in dropped:
            for across, down in ((4 * scale, 4 * scale), (4 * scale, -4 * scale)):
                cv2.line(picture, fixed((x - across, y - down)), fixed((x + across, y + down)),
                         (230, 0, 0), 2 * thick, cv2.LINE_AA, _SHIFT)
        elif key not in used and not photo.cut[(photo.index == key).all(axis=1)].any():
            cv2.rectangle(picture, fixed((x - 4 * scale, y - 4 * scale)),
                          fixed((x + 4 * scale, y + 4 * scale)), _OUTSIDE, thick, cv2.LINE_AA,
                          _SHIFT)
    text = f"arrows: {magnify} x the distance to the smooth lens, {usual:.2f} px rms"
    height, font = picture.shape[0], cv2.FONT_HERSHEY_SIMPLEX
    (wide, high), below = cv2.getTextSize(text, font, 0.5 * scale, thick)
    cv2.rectangle(picture, (0, height - high - 3 * below), (wide + 2 * below, height),
                  (255, 255, 255), -1)
    cv2.putText(picture, text, (below, height - 2 * below), font, 0.5 * scale, (0, 0, 0), thick,
                cv2.LINE_AA)


def _colour(number):
    """One of six well separated colours, in turn."""
    return ((214, 39, 40), (31, 119, 180), (44, 160, 44), (148, 60, 189), (200, 120, 0),
            (0, 150, 160))[number % 6]
