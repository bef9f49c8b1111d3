"""Circle grids and chessboards: rendered with known points, and real photos."""

import numpy as np
import pytest
from photos import real_photos

from ncdc_model.calibration.boards import find_any_chessboard, find_chessboard, find_circles
from ncdc_model.calibration.detect import detect_points, parse_target
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.errors import InputError
from ncdc_model.example import example_camera, target_photo
from ncdc_model.images import mosaic, read_image


def chessboard(columns, rows, step=40, colour=(230, 230, 230)):
    """Picture of a board with ``columns`` x ``rows`` inner corners, and its first corner."""
    y, x = np.mgrid[:(rows + 3) * step, :(columns + 3) * step]
    i, j = x // step - 1, y // step - 1
    board = (i >= 0) & (i <= columns) & (j >= 0) & (j <= rows) & ((i + j) % 2 == 0)
    picture = np.where(board[:, :, None], 20, np.array(colour)).astype(np.uint8)
    return picture, 2 * step - 0.5


@pytest.mark.parametrize("columns,rows", [(9, 6), (8, 6), (6, 4)])
def test_rendered_chessboard(columns, rows):
    picture, first = chessboard(columns, rows)
    found = find_chessboard(picture, columns, rows)
    np.testing.assert_allclose(found.xy, first + 40 * found.index, atol=0.05)
    assert found.index.tolist()[:2] == [[0, 0], [1, 0]] and len(found.index) == columns * rows


@pytest.mark.parametrize("columns,rows", [(9, 6), (8, 6), (6, 4)])
def test_board_upside_down_is_numbered_from_the_top_left(columns, rows):
    picture, first = chessboard(columns, rows)
    found = find_chessboard(np.ascontiguousarray(picture[::-1, ::-1]), columns, rows)
    np.testing.assert_allclose(found.xy, first + 40 * found.index, atol=0.05)


def test_raw_chessboard_with_colour_cast():
    picture, first = chessboard(9, 6, colour=(130, 230, 100))
    found = find_chessboard(mosaic(picture), 9, 6)
    np.testing.assert_allclose(found.xy, first + 40 * found.index, atol=0.5)


def test_size_of_an_unknown_chessboard():
    assert find_any_chessboard(chessboard(9, 6)[0]) in ((9, 6), (6, 9))
    with pytest.raises(InputError, match="no chessboard was found"):
        find_any_chessboard(np.full((120, 160), 200, np.uint8))


def test_rendered_circles():
    y, x = np.mgrid[:280, :360]
    dx, dy = (x + 20) % 40 - 20.0, (y + 20) % 40 - 20.0
    inside = (x > 20) & (x < 340) & (y > 20) & (y < 260)
    ink = np.clip(11.5 - np.hypot(dx, dy), 0, 1) * inside
    found = find_circles((225 - 200 * ink).astype(np.uint8), 8, 6)
    np.testing.assert_allclose(found.xy, 40 * (found.index + 1), atol=0.05)
    np.testing.assert_allclose(found.area, np.pi * 11**2, rtol=0.1)


@pytest.mark.parametrize("text", ["dots:3x3", "chessboard", "circles:8", "chessboard:8x", "squares",
                                  "circles:-8x6", "auto:1x1"])
def test_target_that_is_none(text):
    with pytest.raises(InputError, match="one of dots, circles:CxR, chessboard:CxR or auto"):
        parse_target(text)


def test_target_sizes():
    assert parse_target("circles:10x8") == ("circles", 10, 8)
    with pytest.raises(InputError, match="2 columns and 6 rows, the limits are 3 and 200"):
        parse_target("chessboard:2x6")


def test_photos_without_the_target_are_named_and_the_others_used():
    blank = np.full((360, 480, 3), 200, np.uint8)
    board = chessboard(9, 6)[0]
    images = [("blank.png", blank), ("board.png", board), ("small.png", board[:200])]
    points = detect_points(images, "chessboard:9x6")
    assert [photo.name for photo in points.photos] == ["board.png"]
    assert points.rejected_photos == {
        "blank.png": "no chessboard of 9x6 inner corners was found",
        "small.png": "it is 480x200, the first photo is 480x360"}
    with pytest.raises(InputError, match="no photo shows the target .blank.png: no chessboard of"):
        detect_points(images[:1], "chessboard:9x6")


def test_auto_tells_dots_from_chessboards():
    assert detect_points([("dots", target_photo(example_camera()))], "auto").target == "dots"
    assert detect_points([("board", chessboard(9, 6)[0])], "auto").target == "chessboard"
    with pytest.raises(InputError, match="neither a page of at least 49 dots nor a chessboard"):
        detect_points([("blank", np.full((120, 160), 200, np.uint8))], "auto")


@pytest.mark.parametrize("pattern,target,count", [
    ("chessboard_wide/GOPR00[35]*.jpg", "chessboard:8x6", 48),
    ("opencv/left0[1-6].jpg", "chessboard:9x6", 54),
    ("fisheye/1*.jpg", "chessboard:6x4", 24),
    ("circles/circle_regular/*.jpg", "circles:10x8", 80)])
def test_real_boards(pattern, target, count):
    files = real_photos(pattern)
    points = detect_points(((file.name, read_image(file)) for file in files), target)
    assert not points.rejected_photos
    assert points.count == count * len(files)


def test_real_photo_of_another_target_is_refused():
    file = real_photos("scenes/*.jpg")[0]
    with pytest.raises(InputError, match="no photo shows the target"):
        detect_points([(file.name, read_image(file))], "chessboard:9x6")


def test_overlay_draws_on_the_points():
    picture, _ = chessboard(9, 6)
    photo = find_chessboard(picture, 9, 6)
    drawn = draw_points(picture, photo)
    assert drawn.shape == picture.shape
    x, y = np.round(photo.xy).astype(int).T
    assert (drawn[y, x, 0] > drawn[y, x, 1] + 60).all()          # a red dot on every point
    middle = drawn[y[0], (x[0] + x[1]) // 2]
    assert np.ptp(middle.astype(int)) > 60                        # a coloured line between them
    assert np.ptp(drawn[5, 5].astype(int)) == 0                   # and none elsewhere
