"""Circle grids and chessboards: rendered with known points, and real photos."""

import weakref
from functools import partial

import cv2
import numpy as np
import pytest

from chessboards import chessboard
from ncdc_model.calibration.boards import find_chessboard
from ncdc_model.calibration.charuco import find_any_charuco, find_charuco
from ncdc_model.calibration.detect import detect_points, parse_target
from ncdc_model.calibration.dots import find_spots
from ncdc_model.calibration.grids import find_circles, read_grid
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.example import example_camera, target_photo
from ncdc_model.images import mosaic, read_image
from ncdc_spec.errors import InputError
from photos import full_photos, photos

regress = pytest.mark.regress


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
    picture, first = chessboard(9, 6, light=(130, 230, 100))
    found = find_chessboard(mosaic(picture), 9, 6)
    np.testing.assert_allclose(found.xy, first + 40 * found.index, atol=0.5)


def circles(centres, size, radius=11.0):
    """Picture (h, w) of dark discs at ``centres`` (n, 2)."""
    y, x = np.mgrid[:size[1], :size[0]]
    ink = np.zeros(x.shape)
    for a, b in centres:
        ink = np.maximum(ink, np.clip(radius + 0.5 - np.hypot(x - a, y - b), 0, 1))
    return (225 - 200 * ink).astype(np.uint8)


def lines_of_circles(columns, rows, step=40.0):
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    return step * np.stack([i.ravel() + 1, j.ravel() + 1], axis=1)


def staggered(columns, rows, across=25.0, down=25.0):
    """Centres of OpenCV's asymmetric grid, and their indices in half steps."""
    index = np.array([(2 * c + r % 2, r) for r in range(rows) for c in range(columns)])
    return index * (across, down) + 40.0, index


def test_rendered_circles():
    found = find_circles(circles(lines_of_circles(8, 6), (360, 280)), 8, 6)
    np.testing.assert_allclose(found.xy, 40 * (found.index + 1), atol=0.05)
    np.testing.assert_allclose(found.area, np.pi * 11**2, rtol=0.1)


def test_part_of_a_grid_is_found_and_named():
    picture = circles(lines_of_circles(8, 6), (360, 280))
    photos = [("whole.png", picture), ("part.png", np.ascontiguousarray(picture[:, 100:]).copy())]
    photos[1] = ("part.png", np.pad(photos[1][1], ((0, 0), (0, 100)), constant_values=225))
    points = detect_points(photos, "circles:8x6")
    assert [len(photo.index) for photo in points.photos] == [48, 36]
    np.testing.assert_allclose(points.photos[1].xy, 40 * (points.photos[1].index + 1) - (20, 0),
                               atol=0.05)


NARROW, HIGH = (4, 11, 25.0, 25.0, 1.0), (6, 9, 24.0, 24.0 * 3**0.5, 3**0.5)
WIDE = 12, 7, 24.0 * 3**0.5, 24.0, 3**-0.5


@pytest.mark.longer
@pytest.mark.parametrize("grid,target", [
    (NARROW, "acircles:4x11"), (NARROW, "auto"), (HIGH, "auto"), (WIDE, "acircles:12x7"),
    pytest.param(HIGH, "acircles:6x9", marks=regress), pytest.param(WIDE, "auto", marks=regress)])
def test_staggered_circles(grid, target):
    columns, rows, across, down, aspect = grid
    centres, index = staggered(columns, rows, across, down)
    picture = circles(centres, (centres.max(axis=0) + 60).astype(int))
    points = detect_points([("a.png", picture)], target)
    photo = points.photos[0]
    assert (points.target, len(photo.index)) == ("acircles", columns * rows)
    order = np.lexsort(photo.index.T)
    np.testing.assert_array_equal(photo.index[order], index[np.lexsort(index.T)])
    np.testing.assert_allclose(photo.xy, photo.index * (across, down) + 40.0, atol=0.1)
    assert points.aspect == pytest.approx(aspect)


def test_stray_circles_next_to_a_grid_are_left_out():
    centres = np.vstack([lines_of_circles(8, 6), [(360, 40), (360, 80)]])
    spots = find_spots(circles(centres, (440, 280)))
    grid = read_grid(spots.size, spots.lattices[0])
    assert len(grid.photo.index) == 48 and grid.filled == 1
    assert grid.photo.rejected["not on the grid"] == 2


def charuco(columns=7, rows=5, family="DICT_5X5_100", marker=0.7, step=60):
    """Picture of a board with a margin of one square."""
    board = cv2.aruco.CharucoBoard((columns, rows), 1.0, marker,
                                   cv2.aruco.getPredefinedDictionary(getattr(cv2.aruco, family)))
    return np.pad(board.generateImage((columns * step, rows * step)), step, constant_values=255)


@pytest.mark.longer
@pytest.mark.parametrize("columns,rows,family,marker", [
    (7, 5, "DICT_5X5_100", 0.7), *(pytest.param(*case, marks=regress) for case in (
        (8, 6, "DICT_4X4_50", 0.8), (5, 7, "DICT_6X6_250", 0.6)))])
def test_charuco_boards(columns, rows, family, marker):
    picture = charuco(columns, rows, family, marker)
    assert find_any_charuco(picture) == (columns, rows)
    found = find_charuco(picture, columns, rows)
    assert len(found.index) == (columns - 1) * (rows - 1)
    np.testing.assert_allclose(found.xy, 60 * (found.index + 2) - 0.5, atol=0.3)


@pytest.mark.longer
def test_auto_recognises_a_charuco_board():
    points = detect_points([("board.png", charuco(5, 7, "DICT_6X6_250", 0.6))], "auto")
    assert points.target == "charuco" and points.count == 4 * 6


@pytest.mark.longer
def test_part_of_a_charuco_board_has_the_numbers_of_the_whole():
    picture = charuco(8, 6)
    picture[:, :150] = 255
    found = find_charuco(picture, 8, 6)
    assert 12 <= len(found.index) < 35 and found.index[:, 0].min() > 0
    np.testing.assert_allclose(found.xy, 60 * (found.index + 2) - 0.5, atol=0.3)
    with pytest.raises(InputError, match="0 corners of a ChArUco board of 8x6 squares were found"):
        find_charuco(np.full((200, 200), 255, np.uint8), 8, 6)


def test_repeated_photo_is_named():
    picture = chessboard(9, 6)[0]
    points = detect_points([("a.png", picture), ("b.png", picture), ("a.png", picture)],
                           "chessboard:9x6")
    assert len(points.photos) == 1
    assert points.rejected_photos == dict.fromkeys(
        ("b.png", "a.png (again)"), "it shows the same as a.png: points within 0.05 pixels of each "
                                    "other")


@pytest.mark.parametrize("text", ["dots:3x3", "chessboard", "circles:8", "chessboard:8x", "squares",
                                  "circles:-8x6", "auto:1x1"])
def test_target_that_is_none(text):
    with pytest.raises(InputError, match="one of dots, circles:CxR, acircles:CxR, "):
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
        "small.png": "it is 480x200, most photos are 480x360"}
    with pytest.raises(InputError, match="no photo shows the target .blank.png: no chessboard of"):
        detect_points(images[:1], "chessboard:9x6")


@pytest.mark.longer
def test_auto_distinguishes_dots_from_chessboards():
    assert detect_points([("dots", target_photo(example_camera()))], "auto").target == "dots"
    assert detect_points([("board", chessboard(9, 6)[0])], "auto").target == "chessboard"
    with pytest.raises(InputError, match="neither a whole grid of circles, a page of at least 49"):
        detect_points([("blank", np.full((120, 160), 200, np.uint8))], "auto")


# Points of the photos in full size that detection gives up, with their position: a circle whose
# neighbours predict it elsewhere.
GIVEN_UP = {"circles/circle_regular/*.jpg": 1}


@pytest.mark.parametrize("where", [
    photos, pytest.param(full_photos, marks=regress)], ids=["small", "full"])
@pytest.mark.parametrize("pattern,target,count", [
    ("chessboard_wide/GOPR00[35]*.jpg", "chessboard:8x6", 48),
    pytest.param("opencv/left0[1-6].jpg", "chessboard:9x6", 54, marks=pytest.mark.longer),
    pytest.param("fisheye/1*.jpg", "chessboard:6x4", 24, marks=pytest.mark.longer),
    pytest.param("circles/circle_regular/*.jpg", "circles:10x8", 80, marks=pytest.mark.longer),
    pytest.param("circles/circle_hexagonal/*.jpg", "acircles:14x24", 336,
                 marks=pytest.mark.longer)])
def test_real_boards(where, pattern, target, count):
    files = where(pattern)
    points = detect_points(((file.name, read_image(file)) for file in files), target)
    assert not points.rejected_photos
    given_up = GIVEN_UP.get(pattern, 0) if where is full_photos else 0
    assert points.count == count * len(files) - given_up


@pytest.mark.parametrize("pattern,target,columns,rows", [
    ("fisheye/1.jpg", "chessboard", 6, 4), *(pytest.param(*case, marks=pytest.mark.longer)
                                             for case in (
        ("circles/circle_regular/*1.jpg", "circles", 10, 8),
        ("circles/circle_hexagonal/*4.jpg", "acircles", 24, 28),
        ("dots/dot_pattern_05.jpg", "dots", 85, 54)))])
def test_real_targets_are_recognised(pattern, target, columns, rows):
    file = photos(pattern)[0]
    points = detect_points([(file.name, read_image(file))], "auto")
    assert (points.target, points.columns, points.rows) == (target, columns, rows)


def test_real_photo_of_another_target_is_rejected():
    file = photos("scenes/*.jpg")[0]
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


@pytest.mark.longer
def test_one_photo_is_in_memory():
    """A photo is read again only where OpenCV looks for a size that all photos together give."""
    board = cv2.GaussianBlur(chessboard(9, 6, step=20)[0], (0, 0), 1)
    width, alive, reads = board.shape[1], [], []

    def photo(seen):
        assert all(other() is None for other in alive), "an earlier photo is still in memory"
        picture = board.copy()
        picture[:, seen:] = 200
        alive.append(weakref.ref(picture))
        reads.append(seen)
        return picture
    points = detect_points([(str(seen), partial(photo, seen)) for seen in (
        width, width - 80, width - 10)], "auto")
    assert points.target_size == (9, 6) and len(points.photos) == 2
    assert reads == [width, width - 80, width - 10, width - 80]


@pytest.mark.parametrize("shape, limit", [((7, 99), 8), ((20, 32767), 32766)])
def test_photos_beyond_the_limits_are_named(shape, limit):
    with pytest.raises(InputError, match=f"it is {shape[1]}x{shape[0]}, {limit} pixels on a side"):
        detect_points([("photo", np.full(shape, 200, np.uint8))], "dots")
