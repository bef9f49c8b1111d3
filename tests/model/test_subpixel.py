"""Corners lie where their edges cross, however sharp or blurred they are on one side."""

import cv2
import numpy as np
import pytest

from ncdc_bench.photos import spoil
from ncdc_bench.photos.targets import Bank, Photo, Pose, Truth
from ncdc_model.calibration.boards import find_boards
from ncdc_model.calibration.focus import part_out_of_focus
from ncdc_model.calibration.points import PhotoPoints
from ncdc_model.calibration.subpixel import edge_blur, gaps, refine

COLUMNS, ROWS, STEP = 9, 6, 40


@pytest.fixture(scope="module")
def board():
    """A small clean photo of a board."""
    return Bank(".", 0.5).render(("chessboard", COLUMNS, ROWS, Pose(step=0.2)))


def drawn():
    """A board drawn four times as large and shrunk, and its corners."""
    y, x = np.mgrid[:(ROWS + 3) * STEP * 4, :(COLUMNS + 3) * STEP * 4] / (STEP * 4.0)
    angle = 0.2
    i, j = x * np.cos(angle) + y * np.sin(angle) - 2, y * np.cos(angle) - x * np.sin(angle)
    inside = (i > -1) & (i < COLUMNS) & (j > -1) & (j < ROWS)
    black = inside & ((np.floor(i) + np.floor(j)) % 2 == 0)
    picture = cv2.resize(np.where(black, 20, 220).astype(np.uint8), None, fx=0.25, fy=0.25,
                         interpolation=cv2.INTER_AREA)
    index = np.stack(np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), axis=-1).reshape(-1, 2)
    at = index + (2.0, 0)
    xy = np.stack([at[:, 0] * np.cos(angle) - at[:, 1] * np.sin(angle),
                   at[:, 0] * np.sin(angle) + at[:, 1] * np.cos(angle)], axis=1) * STEP - 0.375
    seen = ((xy > 25) & (xy < np.array(picture.shape[::-1]) - 25)).all(axis=1)
    return Photo(picture, (Truth("chessboard", index[seen], xy[seen], seen[seen]),))


@pytest.mark.parametrize("sigma", [0.5, 2, 4, 6])
def test_corners_of_any_blur_are_right(sigma):
    photo = spoil.blur(drawn(), sigma)
    (truth,) = photo.truths
    start = truth.xy + np.random.default_rng(0).uniform(-1, 1, truth.xy.shape)
    xy = refine(photo.image, truth.index, start, 2.5)
    assert np.linalg.norm(xy - truth.xy, axis=1).max() < 0.15
    blur = edge_blur(photo.image, truth.xy, gaps(truth.index, truth.xy))
    assert np.median(blur) == pytest.approx(max(sigma, 1.1), rel=0.2)


@pytest.mark.longer
@pytest.mark.parametrize("sigma", [4, 9])
def test_a_board_partly_out_of_focus_keeps_its_corners(board, sigma):
    degraded = spoil.part_focus(board, sigma, 5.0, 0.5)
    found = find_boards(degraded.image)[0]
    true = board.truths[0].xy
    off = np.linalg.norm(found.xy[:, None] - true, axis=2).min(axis=1)
    assert len(found.xy) >= 0.9 * len(true) and off.max() < 0.6
    assert any("out of focus" in text for text in found.warnings) == (sigma == 9)
    assert not find_boards(board.image)[0].warnings


def test_dots_partly_out_of_focus_are_warned_of():
    photo = Bank(".", 0.5).render(("dots", 16, 11, Pose(step=0.12)))
    points = PhotoPoints(index=photo.truths[0].index, xy=photo.truths[0].xy,
                         area=np.full(16 * 11, 200.0))

    def said(picture):
        return part_out_of_focus(cv2.cvtColor(picture.image, cv2.COLOR_RGB2GRAY), points)
    assert said(photo) == said(spoil.blur(photo, 3)) == ""
    text = said(spoil.part_focus(photo, 6, 0.0, 0.6))
    assert "a part is out of focus" in text
