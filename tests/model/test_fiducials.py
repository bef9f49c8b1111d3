"""Boards of markers that are not what was looked for are named, and nothing else is."""

import cv2
import numpy as np
import pytest

from ncdc_model.calibration.boards import grey_picture
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.fiducials import other_board
from ncdc_model.example import example_camera, target_photo
from ncdc_spec.errors import InputError


def dictionary(family):
    return cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, family))


def aprilgrid(columns, rows, spacing=0.3, border=2, cell=8):
    """Kalibr's board: markers counted from the bottom left, small squares at their corners."""
    side = (6 + 2 * border) * cell
    gap = round(spacing * side)
    step, size = side + gap, np.array([rows, columns]) * (side + gap) + gap
    page = np.full(size, 255, np.uint8)
    for number in range(columns * rows):
        j, i = divmod(number, columns)
        top, left = size[0] - (j + 1) * step, gap + i * step
        page[top:top + side, left:left + side] = cv2.aruco.generateImageMarker(
            dictionary("DICT_APRILTAG_36h11"), number, side, borderBits=border)
    for j in range(rows + 1):
        for i in range(columns + 1):
            page[j * step:j * step + gap, i * step:i * step + gap] = 0
    return photo(page)


def aruco_grid(family):
    board = cv2.aruco.GridBoard((6, 5), 1.0, 0.3, dictionary(family))
    return photo(board.generateImage((624, 520), marginSize=10))


def photo(page):
    """``page`` with a margin, dim, blurred and noisy."""
    page = cv2.GaussianBlur(np.pad(page, 60, constant_values=255), (0, 0), 0.8)
    noise = np.random.default_rng(1).normal(0, 3, page.shape)
    return np.clip(0.7 * page + 25 + noise, 0, 255).astype(np.uint8)


@pytest.mark.parametrize("columns, rows, spacing", [(6, 6, 0.3), (4, 5, 0.25), (7, 4, 0.2)])
def test_an_aprilgrid_is_named(columns, rows, spacing):
    assert "it shows an AprilGrid (" in other_board(aprilgrid(columns, rows, spacing))


@pytest.mark.longer
@pytest.mark.parametrize("target", ["chessboard:6x6", "charuco:6x6", "dots", "circles:7x7"])
def test_an_aprilgrid_is_no_other_target(target):
    with pytest.raises(InputError, match=r"it shows an AprilGrid \(\d+ of its markers\): --target "
                                         r"aprilgrid:CxR"):
        detect_points([("grid", aprilgrid(6, 6))], target)


@pytest.mark.longer
@pytest.mark.parametrize("columns, rows, border", [(6, 6, 2), (5, 4, 1)])
def test_an_aprilgrid_is_recognised_with_tags_of_another_turn_and_border(columns, rows, border):
    """Here OpenCV's pictures of the tags stand upright, in Kalibr's order."""
    points = detect_points([("grid", aprilgrid(columns, rows, border=border))])
    assert points.choice.startswith(f"aprilgrid:{columns}x{rows}")
    side = (6 + 2 * border) * 8
    assert points.count == 4 * columns * rows
    assert points.spacing == pytest.approx(round(0.3 * side) / side, abs=1e-3)


def test_tags_without_black_squares_are_no_aprilgrid():
    with pytest.raises(InputError, match="most corners of its tags have no black square"):
        detect_points([("grid", aruco_grid("DICT_APRILTAG_36h11"))], "aprilgrid:6x5")


@pytest.mark.parametrize("family, name", [("DICT_4X4_50", "4X4_1000"),
                                          ("DICT_6X6_250", "6X6_1000"),
                                          ("DICT_APRILTAG_36h11", "APRILTAG_36h11")])
def test_a_grid_of_markers_is_named(family, name):
    text = other_board(aruco_grid(family))
    assert f"it shows 30 markers of the family {name} but" in text and "no ChArUco board" in text
    assert "no ChArUco board" not in other_board(aruco_grid(family), "dots")
    assert other_board(aruco_grid(family), "charuco") == ""


def test_pages_and_noise_are_not_named():
    noise = np.random.default_rng(1).integers(0, 256, (600, 800)).astype(np.uint8)
    for picture in (noise, grey_picture(target_photo(example_camera()))):
        assert other_board(picture) == ""
