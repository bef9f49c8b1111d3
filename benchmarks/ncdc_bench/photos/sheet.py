"""Contact sheets of the bad photos with what was found on them."""

import cv2
import numpy as np

from ncdc_model.calibration.overlay import draw_points
from ncdc_model.images import write_image

__all__ = ["ContactSheet"]

_WIDTH, _HEIGHT, _TEXT = 400, 300, 44
_ACROSS, _DOWN = 4, 6


class ContactSheet:
    """Small pictures with a caption: green if the result is the expected one, else red."""

    def __init__(self):
        self._cells = []

    def add(self, photo, outcome):
        """One photo and its :class:`Outcome`."""
        image = photo.image if photo.image.ndim == 3 else np.dstack([photo.image] * 3)
        if outcome.points is not None:
            image = draw_points(image, outcome.points)
        scale = min(_WIDTH / image.shape[1], _HEIGHT / image.shape[0])
        small = cv2.resize(image, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
        cell = np.full((_HEIGHT + _TEXT, _WIDTH, 3), 255, np.uint8)
        cell[_TEXT:_TEXT + small.shape[0], :small.shape[1]] = small[:_HEIGHT, :_WIDTH]
        colour = (0, 120, 0) if outcome.right else (200, 0, 0)
        state = "rejected" if outcome.rejected else (
            f"{outcome.found}/{outcome.visible}, {outcome.false} false")
        for line, text in enumerate((f"{outcome.case} {outcome.photo or ''} [{outcome.expect}]",
                                     f"{state} {outcome.message}")):
            cv2.putText(cell, text[:62], (3, 16 + 18 * line), cv2.FONT_HERSHEY_SIMPLEX, 0.4,
                        colour, 1, cv2.LINE_AA)
        self._cells.append(cell)

    def write(self, folder):
        """``photos-1.jpg`` and so on in ``folder``, 24 photos on each."""
        page = _ACROSS * _DOWN
        for start in range(0, len(self._cells), page):
            cells = self._cells[start:start + page]
            cells += [np.full_like(cells[0], 255)] * (-len(cells) % _ACROSS)
            rows = [np.hstack(cells[k:k + _ACROSS]) for k in range(0, len(cells), _ACROSS)]
            write_image(folder / f"photos-{start // page + 1}.jpg", np.vstack(rows))
