"""The bad photos: how each is made, its target, and the expected result.

The expectations were written down before detection was first run, from a careful look at each
photo, and have not been tuned since:

- ``use``: the eye can distinguish the points, they must be found;
- ``reject``: the target asked for is not in the photo, so one sentence must say so;
- ``either``: too bad to ask for: right points or a sentence.

Whatever is found must be right in all three.
"""

from dataclasses import replace

import cv2
import numpy as np

from ncdc_bench.photos import spoil
from ncdc_bench.photos.case import EITHER, REJECT, USE, Case, board, case, charuco, circles, page
from ncdc_bench.photos.cases_of_defects import DEFECTS
from ncdc_bench.photos.targets import Photo, Pose, side_by_side
from ncdc_model.example import example_camera, scene_photo

__all__ = ["CASES", "Case"]

# A hand from the right, and one from below; parts of width and height.
_HAND = [(1.0, 0.30), (0.72, 0.36), (0.60, 0.40), (0.60, 0.47), (0.70, 0.48), (0.57, 0.53),
         (0.58, 0.60), (0.71, 0.58), (0.62, 0.66), (0.64, 0.71), (0.80, 0.66), (1.0, 0.72)]
_THUMB = [(0.30, 1.0), (0.36, 0.72), (0.42, 0.62), (0.47, 0.63), (0.48, 0.75), (0.55, 1.0)]
_STROKES = [((0.1, 0.15), (0.85, 0.4)), ((0.2, 0.8), (0.9, 0.55)), ((0.45, 0.1), (0.5, 0.95)),
            ((0.6, 0.3), (0.75, 0.8)), ((0.15, 0.5), (0.4, 0.55))]


def _two(bank, kind, first, second, step, **more):
    return bank.render((kind, *first, Pose((-0.62, -0.05), step, 6.0, (5.0, 12.0))),
                       (kind, *second, Pose((0.66, 0.08), step, -9.0, (-6.0, -10.0))),
                       clutter=True, **more)


def _grey(bank, level):
    return Photo(np.full((480, 640, 3), level, np.uint8), ())


def _letters(bank):
    """A page of text: lines of letters at equal distances."""
    image = np.full((960, 1280, 3), 225, np.uint8)
    for row in range(22):
        text = "".join(chr(65 + (7 * row + 11 * k + k * k) % 26) for k in range(34))
        cv2.putText(image, text, (60, 60 + 40 * row), cv2.FONT_HERSHEY_SIMPLEX, 1.0, (30, 30, 30),
                    3, cv2.LINE_AA)
    return Photo(image, ())


def _house(bank):
    """Rows of windows. What is below them, the chart and the tiles, is a chessboard indeed."""
    return Photo(scene_photo(example_camera())[:180].copy(), ())


def _tiles(bank):
    """Round tiles of uneven size and position, as on a bathroom's floor."""
    rng, image = np.random.default_rng(5), np.full((960, 1280, 3), 200, np.uint8)
    for y in range(30, 960, 45):
        for x in range(30, 1280, 45):
            at = np.rint([x, y] + rng.normal(0, 4.5, 2)).astype(int).tolist()
            cv2.circle(image, at, int(rng.integers(8, 17)), (60, 50, 50), -1, cv2.LINE_AA)
    return Photo(image, ())


def _noise(bank):
    return Photo(np.random.default_rng(3).integers(0, 256, (480, 640, 3)).astype(np.uint8), ())


def _middle_fifth(photo):
    side = 0.5 * 0.2**0.5
    box = [(0.5 - side, 0.5 - side), (0.5 + side, 0.5 - side), (0.5 + side, 0.5 + side),
           (0.5 - side, 0.5 + side)]
    return spoil.cover(photo, box)


def _perspective(photo):
    width, height = photo.size
    ends = np.array([[0.22, 0.10], [0.97, 0.02], [0.90, 0.98], [0.15, 0.75]])
    start = np.float32([[0, 0], [width, 0], [width, height], [0, height]])
    matrix = cv2.getPerspectiveTransform(start, np.float32(ends * (width, height)))
    return spoil.warp(photo, matrix.astype(np.float64), ground=90)


def _street_right(photo, bank):
    return spoil.fill(photo, bank.street(photo.size), (0.5, 0.0, 1.0, 1.0))


def _less(photo):
    """The same photo without its last column and row of pixels, as another camera mode gives."""
    width, height = photo.size
    return replace(photo, image=photo.image[:-1, :-1].copy(), truths=tuple(
        truth.moved(lambda xy: xy, (width - 1, height - 1)) for truth in photo.truths))


def _cut(photo):
    return spoil.turn(photo, 0, 1.0, (0.36, 0.05), ground=60)


_DOTS = [
    case("dots, blurred by 2 px", USE, lambda b: spoil.blur(b.example(), 2)),
    case("dots, blurred by 4 px", USE, lambda b: spoil.blur(b.example(), 4)),
    case("dots, blurred by 12 px", EITHER, lambda b: spoil.blur(b.example(), 12)),
    case("dots, shaken by 9 px", USE, lambda b: spoil.shake(b.example(), 9)),
    case("dots, dark", USE, lambda b: spoil.darken(b.example(), 0.10)),
    case("dots, black", EITHER, lambda b: spoil.darken(b.example(), 0.012)),
    case("dots, noise of 25", USE, lambda b: spoil.noise(b.example(), 25)),
    case("dots, exposed 2.5 times", USE, lambda b: spoil.brighten(b.real("page"), 2.5)),
    case("dots, JPEG 5", USE, lambda b: spoil.compress(b.real("page"))),
    case("dots, JPEG 5, rendered", USE, lambda b: spoil.compress(page(b))),
    case("dots, turned by 30", USE, lambda b: spoil.turn(b.real("page"), 30)),
    case("dots, turned by 30, on a street", USE, lambda b: spoil.turn(
        b.real("barrel"), 30, 0.8, ground=b.street(b.real("barrel").size))),
    case("dots, a quarter of a street", USE, lambda b: spoil.on_clutter(
        b.real("barrel"), b.street(b.real("barrel").size), 0.5)),
    case("dots, a street on the right half", USE, lambda b: _street_right(b.real("page"), b)),
    case("dots, street right, barrel", USE, lambda b: _street_right(b.real("barrel"), b)),
    case("dots, pen marks", USE, lambda b: spoil.pen(b.real("barrel"), _STROKES, 5)),
    case("dots, pen marks, small page", USE, lambda b: spoil.pen(b.example(), _STROKES, 3)),
    case("dots, mirrored in a dark border", USE, lambda b: spoil.mirror_border(b.real("page"))),
    case("dots, mirrored, barrel", USE, lambda b: spoil.mirror_border(
        b.real("barrel"), 0.1, 0.5)),
    case("dots, middle fifth covered", USE, lambda b: _middle_fifth(page(
        b, Pose(step=0.04, turn=4.0), size=(40, 35)))),
    case("dots, middle fifth covered, real", USE, lambda b: _middle_fifth(b.real("barrel"))),
    case("dots, a hand", USE, lambda b: spoil.cover(b.real("barrel"), _HAND, _THUMB)),
    case("dots, two pages", USE, lambda b: _two(b, "dots", (15, 17), (14, 18), 0.06)),
    case("dots, two pages side by side", USE, lambda b: side_by_side(b.example(), b.example())),
    case("dots, glare", USE, lambda b: spoil.glare(b.real("barrel"), [(0.3, 0.4), (0.7, 0.6)])),
    case("dots, shadow", USE, lambda b: spoil.shade(b.real("page"))),
    case("dots, part of the page", USE, lambda b: _cut(page(b))),
    case("dots, seen from the side", USE, lambda b: _perspective(b.real("barrel"))),
    case("dots, on clutter", USE, lambda b: page(b, Pose((0.1, 0.0), 0.055, 33.0))),
    case("dots, raw frame, reddish", USE, lambda b: spoil.raw(b.real("barrel"))),
    case("dots, white on black", EITHER, lambda b: replace(
        b.real("page"), image=255 - b.real("page").image)),
    case("dots, asked as circles:4x11", REJECT, lambda b: b.real("barrel"), "circles:4x11"),
    case("dots, asked as acircles:4x11", REJECT, lambda b: b.real("page"), "acircles:4x11"),
    case("dots, asked as chessboard:9x6", REJECT, lambda b: b.example(), "chessboard:9x6"),
]
_CIRCLES = [
    case("circles, blurred by 3 px", USE, lambda b: spoil.blur(b.real("circles"), 3)),
    case("circles, dark", USE, lambda b: spoil.darken(b.real("circles"), 0.12)),
    case("circles, turned by 45", USE, lambda b: spoil.turn(b.real("circles2"), 45, 0.8)),
    case("circles, a hand", USE, lambda b: spoil.cover(b.real("circles"), _HAND), "circles:10x8"),
    case("circles, a hand, clutter", USE, lambda b: spoil.cover(circles(b), _HAND),
          "circles:9x7"),
    case("circles, part of the grid", USE, lambda b: _cut(circles(b)), "circles:9x7"),
    case("circles, two grids", USE, lambda b: _two(b, "circles", (6, 7), (6, 7), 0.14)),
    case("circles, two sizes of grids", USE, lambda b: _two(b, "circles", (6, 7), (7, 6), 0.13),
          "circles:6x7"),
    case("circles, JPEG 5", USE, lambda b: spoil.compress(b.real("circles"))),
    case("circles, glare", USE, lambda b: spoil.glare(circles(b), [(0.42, 0.4)], 0.06),
          "circles:9x7"),
    case("circles, pen marks", USE, lambda b: spoil.pen(circles(b), _STROKES, 4), "circles:9x7"),
    case("circles, on clutter", USE, lambda b: circles(b, Pose((0.2, 0.1), 0.1, 25.0))),
    case("circles, shaken by 7 px", USE, lambda b: spoil.shake(b.real("circles2"), 7)),
    case("circles, asked as 12x9", EITHER, lambda b: b.real("circles"), "circles:12x9"),
    case("circles, asked as 7x5", REJECT, lambda b: b.real("circles"), "circles:7x5"),
    case("circles, a cut photo first", (USE,) * 4, lambda b: [
        _cut(circles(b)), circles(b), circles(b, Pose((0.1, 0.0), 0.12, -12.0, (15.0, 20.0))),
        circles(b, Pose((-0.1, 0.0), 0.12, 15.0, (-20.0, 5.0)))]),
    case("hexagonal, blurred by 2 px", USE, lambda b: spoil.blur(b.real("hexagonal"), 2)),
    case("hexagonal, a hand", USE, lambda b: spoil.cover(b.real("hexagonal"), _HAND),
          "acircles:14x24"),
    case("hexagonal, turned by 20", USE, lambda b: spoil.turn(b.real("hexagonal"), 20)),
    case("hexagonal, JPEG 5", USE, lambda b: spoil.compress(b.real("hexagonal"))),
    case("staggered, on clutter", USE, lambda b: b.render(
        ("acircles", 4, 11, Pose(step=0.1, turn=10.0)), clutter=True)),
]
_BOARDS = [
    case("board, blurred by 6 px", USE, lambda b: spoil.blur(board(b), 6)),
    case("board, blurred by 3 px, real", USE, lambda b: spoil.blur(b.real("wide1"), 3)),
    case("board, blurred by 20 px", EITHER, lambda b: spoil.blur(board(b), 20)),
    case("board, fisheye 1600x1200", USE, lambda b: board(
        b, Pose((0.3, 0.2), 0.14, 12.0, (20.0, -15.0)), size=(9, 6), view=0.34)),
    case("board, 15x9", USE, lambda b: board(b, Pose(step=0.11), size=(15, 9))),
    case("board, 15x9, blurred by 3 px", USE, lambda b: spoil.blur(board(
        b, Pose((0.1, 0.1), 0.1, 20.0, (20.0, 10.0)), size=(15, 9)), 3)),
    case("board, two boards", USE, lambda b: _two(b, "chessboard", (5, 7), (5, 7), 0.14)),
    case("board, two sizes of boards", USE, lambda b: _two(b, "chessboard", (6, 4), (4, 7), 0.14),
          "chessboard:6x4"),
    case("board, two photos side by side", USE, lambda b: side_by_side(
        b.real("wide1"), b.real("mild1"))),
    case("board, a hand, real", USE, lambda b: spoil.cover(b.real("wide3"), _HAND),
          "chessboard:8x6"),
    case("board, a hand", USE, lambda b: spoil.cover(board(b), _HAND)),
    case("board, a thumb on its rim", USE, lambda b: spoil.cover(board(b, size=(9, 6)), [
        (x, y - 0.1) for x, y in _THUMB]), "chessboard:9x6"),
    case("board, a cut photo first", (USE,) * 5, lambda b: [
        _cut(b.real("mild1")), *(b.real(f"mild{k}") for k in (1, 2, 3, 4))]),
    case("board, cut by the border", USE, lambda b: _cut(board(b))),
    case("board, dark", USE, lambda b: spoil.darken(b.real("mild2"), 0.12)),
    case("board, JPEG 5", USE, lambda b: spoil.compress(b.real("mild3"))),
    case("board, JPEG 5, clutter", USE, lambda b: spoil.compress(board(b, Pose(
        (0.2, -0.1), 0.12, -20.0, (25.0, 10.0))))),
    case("board, glare", USE, lambda b: spoil.glare(board(b), [(0.4, 0.45)], 0.06)),
    case("board, pen marks", USE, lambda b: spoil.pen(board(b), _STROKES, 4)),
    case("board, turned by 45", USE, lambda b: spoil.turn(b.real("mild4"), 45, 0.8)),
    case("board, turned by 90", USE, lambda b: spoil.turn(b.real("wide2"), 90)),
    case("board, exposed 2.5 times", USE, lambda b: spoil.brighten(b.real("mild1"), 2.5)),
    case("board, shaken by 9 px", USE, lambda b: spoil.shake(board(b), 9)),
    case("board, noise of 25", USE, lambda b: spoil.noise(b.real("wide4"), 25)),
    case("board, shadow", USE, lambda b: spoil.shade(board(b))),
    case("board, seen from the side", USE, lambda b: _perspective(b.real("mild1"))),
    case("board, fisheye, upright", USE, lambda b: spoil.turn(b.real("fisheye1"), 7)),
    case("board, fisheye, blurred by 2 px", USE, lambda b: spoil.blur(b.real("fisheye2"), 2)),
    case("board, asked as 7x5", REJECT, lambda b: b.real("wide1"), "chessboard:7x5"),
    case("board, asked as 7x5, rendered", REJECT, lambda b: board(b), "chessboard:7x5"),
    case("board, asked as dots", REJECT, lambda b: board(b), "dots"),
    case("board, one photo a pixel smaller", (REJECT, USE, USE), lambda b: [
        _less(b.real("mild1")), b.real("mild2"), b.real("mild3")], "chessboard:9x6"),
    case("board, a blank and a street among them", (REJECT, REJECT, USE, USE), lambda b: [
        _grey(b, 180), Photo(b.street((640, 480)), ()), b.real("wide1"), b.real("wide2")]),
    case("board, a blurred one among them", (EITHER, USE, USE), lambda b: [
        spoil.blur(b.real("wide1"), 9), b.real("wide2"), b.real("wide3")]),
]
_CHARUCO = [
    case("charuco, blurred by 3 px", USE, lambda b: spoil.blur(charuco(b), 3)),
    case("charuco, blurred by 10 px", EITHER, lambda b: spoil.blur(charuco(b), 10)),
    case("charuco, dark", USE, lambda b: spoil.darken(charuco(b), 0.12)),
    case("charuco, a hand", USE, lambda b: spoil.cover(charuco(b), _HAND), "charuco:9x7"),
    case("charuco, JPEG 5", USE, lambda b: spoil.compress(charuco(b))),
    case("charuco, glare", USE, lambda b: spoil.glare(charuco(b), [(0.45, 0.5)], 0.06)),
    case("charuco, turned by 120", USE, lambda b: charuco(b, Pose(step=0.13, turn=120.0))),
    case("charuco, two boards", EITHER, lambda b: _two(b, "charuco", (5, 7), (5, 7), 0.17)),
    case("charuco, cut by the border", USE, lambda b: _cut(charuco(b)), "charuco:9x7"),
    case("charuco, pen marks", USE, lambda b: spoil.pen(charuco(b), _STROKES, 4), "charuco:9x7"),
    case("charuco, fisheye 1600x1200", USE, lambda b: charuco(
        b, Pose((0.2, 0.2), 0.16, 30.0, (15.0, 20.0)), view=0.34, size=(9, 7)), "charuco:9x7"),
    case("charuco, asked as 7x5", REJECT, lambda b: charuco(b), "charuco:7x5"),
    case("charuco, mirrored", EITHER, lambda b: replace(
        charuco(b), image=charuco(b).image[:, ::-1].copy(), truths=()), "charuco:9x7"),
]
_NONE = [
    case("no target: a street", REJECT, lambda b: Photo(b.street((1280, 960)), ())),
    case("no target: a grey wall", REJECT, lambda b: _grey(b, 128)),
    case("no target: the lens cap", REJECT, lambda b: spoil.noise(_grey(b, 2), 1.5)),
    case("no target: a house front", REJECT, _house),
    case("no target: a page of text", REJECT, _letters),
    case("no target: round tiles", REJECT, _tiles),
    case("no target: noise", REJECT, _noise),
]
CASES = tuple(_DOTS + _CIRCLES + _BOARDS + _CHARUCO + _NONE + DEFECTS)
