"""Corners of a board have edges between black and white between them; other corners have not."""

import cv2
import numpy as np

from chessboards import chessboard
from ncdc_model.calibration.board_edges import are_squares, on_edges, readings
from ncdc_model.calibration.corners import check_squares, find_corner_lattices


def board(columns=6, rows=5, step=40):
    picture, first = chessboard(columns, rows, step, 220)
    index = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1).reshape(-1, 2)
    picture = cv2.GaussianBlur(picture, (0, 0), 1)
    return picture.astype(np.float32), index, index * step + first


def test_all_corners_of_a_board_are_on_edges():
    assert on_edges(*board()).all()


def test_what_lies_where_the_next_corner_would_is_not():
    picture, index, xy = board()
    beyond = np.array([(6, j) for j in range(5)])
    keep = on_edges(picture, np.vstack([index, beyond + (1, 0)]),
                    np.vstack([xy, beyond * 40.0 + 119.5]))
    assert keep[:30].all() and not keep[30:].any()


def test_one_reading_of_an_oblique_lattice_follows_the_squares():
    picture, index, xy = board()
    walked = index @ np.array([[1, 0], [1, 1]])        # a step down goes to the right as well
    assert not check_squares(picture, walked, xy).any()
    assert any(check_squares(picture, walked @ reading, xy).all() for reading in readings())


def test_a_board_from_far_aside_is_found():
    picture, index, xy = board(8, 6, 60)
    ends = np.float32([[0, 0], [picture.shape[1], 0], picture.shape[::-1], [0, picture.shape[0]]])
    moved = np.float32([[230, 30], [430, 30], [640, 210], [20, 210]])
    matrix = cv2.getPerspectiveTransform(ends, moved)
    seen = cv2.warpPerspective(picture, matrix, (660, 240), flags=cv2.INTER_AREA, borderValue=220)
    true = cv2.perspectiveTransform(xy[None], matrix)[0]
    found = find_corner_lattices(seen.astype(np.uint8))[0]
    off = np.linalg.norm(found.xy[:, None] - true, axis=2).min(axis=1)
    assert len(found.xy) >= 36 and off.max() < 0.5


def test_touching_circles_are_no_squares():
    picture, index, xy = board()
    round_ = np.full(picture.shape, 220, np.uint8)
    for i in range(7):
        for j in range(6):
            if (i + j) % 2 == 0:
                cv2.circle(round_, (40 * i + 60, 40 * j + 60), 20, 20, -1)
    assert are_squares(picture, index, xy)
    assert not are_squares(round_.astype(np.float32), index, xy)
