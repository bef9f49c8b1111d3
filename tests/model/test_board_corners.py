"""Corners of boards: near markers, on raw frames, and beyond the flat picture."""

from functools import cache

import numpy as np
import pytest

from ncdc_model.calibration.charuco import find_charuco
from ncdc_model.calibration.detect import detect_points
from ncdc_model.calibration.dots import find_dots
from ncdc_model.calibration.filters import green_picture, pattern_of
from ncdc_model.calibration.grids import find_circles
from ncdc_model.calibration.judged import judged
from ncdc_model.calibration.overlay import draw_points
from ncdc_model.example import example_camera, target_photo
from ncdc_model.images import mosaic
from ncdc_model.lens import choose_frame
from ncdc_model.nearest import Nearest
from ncdc_model.photo.photo import Photo
from ncdc_spec.errors import InputError
from small_boards import SIZE, Equidistant, board_photo

RED, BLUE = 1.004, 0.997       # size of their pictures, green's is 1
CORNER = np.linalg.norm(np.array(SIZE) - 1) / 2


def off(found, truth):
    """Distances (n,) of positions from the nearest true ones."""
    return Nearest(truth.xy).query(found)[0][:, 0]


def test_markers_do_not_move_the_corners_at_the_rim_of_a_wide_lens():
    shot = board_photo("charuco", 12, 9, Equidistant(130.0), 56.0)
    (truth,) = shot.truths
    found = find_charuco(shot.image, 12, 9)
    place = {tuple(key): xy for key, xy in zip(truth.index.tolist(), truth.xy)}
    far = np.array([np.linalg.norm(place[tuple(key)] - xy)
                    for key, xy in zip(found.index.tolist(), found.xy)])
    assert len(found.index) >= 0.95 * truth.visible.sum()
    assert np.sqrt(np.mean(far**2)) < 0.08 and far.max() < 0.3


@cache
def colours(kind):
    """RGB picture of a board with red and blue of other sizes, and the truth of green."""
    shots = [board_photo(*kind, Equidistant(70.0, scale), 34.0, seed=k)
             for k, scale in enumerate((RED, 1.0, BLUE))]
    return np.stack([shot.image for shot in shots], axis=2), shots[1].truths[0]


@pytest.mark.parametrize("gains, pattern, declared", [
    ((1, 1, 1), "RGGB", None), ((.6, 1, .75), "GRBG", None), ((1, 1, 1), "BGGR", "BGGR")])
def test_points_of_raw_frames_are_of_green_and_red_and_blue_are_told(gains, pattern, declared):
    rgb, truth = colours(("chessboard", 10, 7))
    raw = mosaic((rgb * gains).astype(np.uint8), pattern)
    points = detect_points([("raw.png", Photo(raw, declared) if declared else raw)],
                           "chessboard:10x7")
    far = off(points.photos[0].xy, truth)
    assert np.sqrt(np.mean(far**2)) < 0.08 and far.max() < 0.3
    colour = points.colour
    assert colour["points_of"] == "green sites" and colour["points"] > 40
    # A filter that no file declares is known but for red and blue.
    first, second = sorted((colour["red_px"], colour["blue_px"]), reverse=declared != pattern)
    if declared:
        first, second = colour["red_px"], colour["blue_px"]
    assert first == pytest.approx((RED - 1) * CORNER, abs=0.2)
    assert second == pytest.approx((BLUE - 1) * CORNER, abs=0.2)
    assert max(colour["red_error_px"], colour["blue_error_px"]) < 0.1


def test_points_are_of_all_sites_where_red_and_blue_lie_at_the_same_places():
    """Half of the sites would give more noise, and no other points."""
    picture = target_photo(example_camera())
    points = detect_points([("raw.png", picture)], "dots")
    assert points.colour["points_of"] == "all sites" and points.colour["pattern"] == "RGGB"
    assert max(abs(points.colour[key]) for key in ("red_px", "blue_px")) < 0.05
    alone = find_dots(picture)
    np.testing.assert_array_equal(points.photos[0].xy, alone.xy)


def test_points_of_a_grey_picture_are_of_all_its_pixels():
    rgb, _ = colours(("chessboard", 10, 7))
    points = detect_points([("grey.png", rgb[:, :, 1])], "chessboard:10x7")
    assert points.colour is None
    raw = Photo(mosaic(rgb), "MONO")
    assert detect_points([("grey.png", raw)], "chessboard:10x7").colour is None


@pytest.mark.parametrize("pattern, guessed", [("RGGB", "RGGB"), ("BGGR", "RGGB"),
                                              ("GRBG", "GRBG"), ("GBRG", "GRBG")])
def test_the_green_sites_are_known_by_the_colour_cast(pattern, guessed):
    rgb = np.zeros((40, 60, 3), np.uint8) + np.array([120, 200, 90], np.uint8)
    raw = mosaic(rgb, pattern)
    assert pattern_of(raw) == guessed and (green_picture(raw, guessed) == 200).all()
    even = np.zeros((40, 60, 3), np.uint8) + np.array([100, 200, 100], np.uint8)
    assert pattern_of(mosaic(even, pattern)) == guessed
    assert pattern_of(mosaic(0 * rgb + 150, pattern)) is None


@pytest.mark.parametrize("find", [find_dots, lambda image: find_circles(image, 11, 8)])
def test_black_squares_are_no_dots(find):
    """Squares that do not touch, as those between the tags of an AprilGrid."""
    page = np.full((360, 480), 230, np.uint8)
    for j in range(8):
        for i in range(11):
            page[20 + 40 * j:38 + 40 * j, 20 + 40 * i:38 + 40 * i] = 30
    with pytest.raises(InputError, match="88 dark spots on one lattice are squares, not round"):
        find(page)
    y, x = np.mgrid[:360, :480]
    discs = np.where(np.hypot((x - 9) % 40 - 20, (y - 9) % 40 - 20) < 10, 30, 230)
    assert len(find_circles(discs.astype(np.uint8), 12, 9).index) >= 80


@cache
def wide():
    """A board that a lens too wide for a flat picture sees, its points and their frame."""
    shot = board_photo("chessboard", 12, 9, Equidistant(174.0), 62.0)
    points = detect_points([("wide.png", shot.image)], "chessboard:12x9")
    return shot, points, judged(points)[1]


def test_points_outside_the_flat_picture_are_marked_and_not_crossed_out():
    shot, points, frame = wide()
    outside = frame.rejected[next(reason for reason in frame.rejected
                                  if "outside" in reason.value)]
    assert outside > 10 and not frame.gross
    drawn = draw_points(shot.image, points.photos[0], frame)
    red = (drawn == (230, 0, 0)).all(axis=2).sum()
    marked = (np.abs(drawn.astype(int) - (0, 110, 200)).max(axis=2) < 12).sum()
    assert red == 0 and marked > 2 * outside


@pytest.mark.parametrize("degrees", [171.0, 178.0, 190.0])
@pytest.mark.parametrize("zoom", ["fit", "fill"])
def test_a_refusal_of_a_wide_lens_names_a_zoom_that_shows_it(degrees, zoom):
    scale = SIZE[0] / np.radians(degrees)
    middle = (np.array(SIZE) - 1) / 2

    def to_ideal(x, y):
        a, b = (np.asarray(x) - middle[0]) / scale, (np.asarray(y) - middle[1]) / scale
        theta = np.hypot(a, b)
        grown = np.where(theta < np.pi / 2, np.tan(theta) / np.maximum(theta, 1e-12), np.nan)
        return a * grown, b * grown

    def to_distorted(a, b):
        far = np.hypot(a, b)
        part = np.arctan(far) / np.maximum(far, 1e-12) * scale
        return a * part + middle[0], b * part + middle[1]
    if zoom == "fill" and degrees < 180:
        assert choose_frame(to_ideal, to_distorted, SIZE, SIZE, zoom)
        return
    with pytest.raises(InputError, match=r"--zoom 0\.\d+ shows 1\d\d degrees") as refused:
        choose_frame(to_ideal, to_distorted, SIZE, SIZE, zoom)
    number = float(str(refused.value).split("--zoom ")[1].split()[0])
    frame = choose_frame(to_ideal, to_distorted, SIZE, SIZE, number)
    x, _ = to_distorted(*frame.ideal(np.array([0, SIZE[0] - 1]), (SIZE[1] - 1) / 2))
    assert (0 <= x).all() and (x <= SIZE[0] - 1).all() and np.ptp(x) > 0.6 * SIZE[0]
