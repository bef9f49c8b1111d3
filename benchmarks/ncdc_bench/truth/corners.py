"""Corners found on photographed boards, compared with the true ones."""

from dataclasses import dataclass

import numpy as np

from ncdc_bench.photos.measure import renumbered
from ncdc_bench.truth.boards import BOARDS, SPACING, board_of, photograph_board
from ncdc_model.calibration.detect import detect_points
from ncdc_model.nearest import Nearest

__all__ = ["Corners", "corner_row", "detect_boards", "judge_corners"]

_OWN_NUMBERS = "charuco", "aprilgrid"     # the markers say where the first corner is


@dataclass(frozen=True)
class Corners:
    """Corners of one photo: ``visible`` ones, ``used`` ones, ``misnumbered`` ones of these, and the
    distances ``off`` (n,) of the others from the truth in pixels."""
    visible: int
    used: int
    misnumbered: int
    off: np.ndarray


def detect_boards(lens, kind, photos, seed=0):
    """(:class:`TargetPoints`, a :class:`Corners` per photo) of so many ``photos`` of a board."""
    shots = [photograph_board(lens, board_of(lens, kind, k), seed + k) for k in range(photos)]
    target = "{}:{}x{}".format(kind, *BOARDS[kind]) + f":{SPACING}" * (kind == "aprilgrid")
    points = detect_points([(f"{k}.png", shot.image) for k, shot in enumerate(shots)], target)
    found = {photo.name: photo for photo in points.photos}
    return points, [judge_corners(shot.truths[0], found.get(f"{k}.png"))
                    for k, shot in enumerate(shots)]


def judge_corners(truth, photo):
    """:class:`Corners` of the PhotoPoints ``photo``, or None, against a :class:`Truth`.

    A corner is misnumbered if the true corner of its number is not the closest one. A chessboard
    has no first corner: its numbers count up to a turn, and a part's from any corner.
    """
    visible = int(truth.visible.sum())
    if photo is None:
        return Corners(visible, 0, 0, np.empty(0))
    away, nearest = (part[:, 0] for part in Nearest(truth.xy).query(photo.xy))
    index = photo.index
    if truth.kind not in _OWN_NUMBERS:
        index = renumbered(index, truth.index[nearest], away < 3)
    wrong = (index != truth.index[nearest]).any(axis=1)
    return Corners(visible, len(index), int(wrong.sum()), away[~wrong])


def corner_row(corners):
    """Fields of the report of a list of :class:`Corners`."""
    off = np.concatenate([part.off for part in corners])
    return {"corners_visible": sum(part.visible for part in corners),
            "corners_used": sum(part.used for part in corners),
            "corners_misnumbered": sum(part.misnumbered for part in corners),
            "corner_rms_px": float(np.sqrt(np.mean(off**2))) if len(off) else None,
            "corner_max_px": float(off.max()) if len(off) else None}
