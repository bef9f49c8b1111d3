"""Pages of targets: true to scale, and what is painted of them is found whole."""

import json
import re

import numpy as np
import pytest

from cases import cases
from ncdc.cli import main
from ncdc.target.draw import page
from ncdc.target.layout import Circle, layout_of, paper_of
from ncdc_model.calibration.detect import detect_points
from vector_pages import painted, shapes

KINDS = ["dots", "circles:10x7", "acircles:4x11", "acircles:5x7", "chessboard:9x6",
         "chessboard:7x7", "charuco:10x7", "charuco:5x9",
         "aprilgrid:6x4:0.3"]


@pytest.fixture(scope="module")
def pages():
    """Layout, PDF and SVG of each kind on A4, made once."""
    made = {}

    def get(kind):
        if kind not in made:
            layout = layout_of(kind, paper_of("A4"))
            made[kind] = layout, page(layout, "pdf"), page(layout, "svg")
        return made[kind]
    return get


def boxes(polygons):
    """x, y, width and height of each polygon's rectangle, as rows."""
    low, high = (np.array([edge(p, axis=0) for p in polygons]) for edge in (np.min, np.max))
    return np.hstack([low, high - low])


def ruler(found):
    """Boxes of the ruler: its line, 0.2 mm high, and the ticks on it."""
    [line] = found[(found[:, 3] < .3) & (found[:, 2] > 50)]
    return line, found[np.abs(found[:, 1] + found[:, 3] - line[1]) < 1e-3]


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("form", [1, 2])
def test_every_shape_lies_on_paper_where_it_is_laid_out(pages, kind, form):
    layout, data = pages(kind)[0], pages(kind)[form]
    size, polygons = shapes(data)
    assert size == pytest.approx((297, 210), abs=1e-3)
    expected = [(s.x - s.diameter / 2, s.y - s.diameter / 2, s.diameter, s.diameter)
                if isinstance(s, Circle) else (s.x, s.y, s.width, s.height) for s in layout.shapes]
    # Outlines of letters are none in either form: all but the shapes belong to the ruler.
    found = boxes(polygons)
    assert np.abs(found[:len(expected)] - expected).max() < 1e-3
    line, ticks = ruler(found)
    assert line[2] == pytest.approx(100, abs=1e-3) and len(ticks) == 11
    assert ticks[:, 0].min() == pytest.approx(line[0], abs=1e-3)
    assert (ticks[:, 0] + ticks[:, 2]).max() == pytest.approx(line[0] + 100, abs=1e-3)
    assert len(found) == len(expected) + 12
    # In a photo nothing may look as if it touched a dot: 3.5 mm cost five of a page's dots.
    lowest = np.array(expected)[:, [1, 3]].sum(axis=1).max()
    assert ticks[:, 1].min() - lowest > 6


@pytest.mark.parametrize("kind", KINDS)
def test_points_are_as_far_apart_as_the_page_says(pages, kind):
    layout = pages(kind)[0]
    found = boxes(shapes(pages(kind)[1])[1])[:len(layout.shapes)]
    middles = found[:, :2] + found[:, 2:] / 2
    if kind.startswith("acircles"):
        # Millimetres from a line to the next, across lines that lie or stand.
        gaps = [np.unique(np.diff(np.unique(np.round(side, 2))).round(2)) for side in middles.T]
        assert all(gap == pytest.approx([layout.step / 2], abs=.02) for gap in gaps)
    elif kind.startswith("charuco"):
        squares = found[np.abs(found[:, 2] - layout.step) < 1e-3]
        assert len(squares) and squares[:, 3] == pytest.approx(layout.step, abs=1e-3)
    else:
        # Every other square is black; of an AprilGrid the small ones are a tag and a gap apart.
        step = {"chessboard": 2, "aprilgrid": 1.3}.get(kind.partition(":")[0], 1)
        first = found[np.abs(found[:, 1] - found[0, 1]) < 1e-3]
        assert np.diff(first[:, 0]) == pytest.approx(step * layout.step, abs=1e-3)
    assert f"{layout.step:g} mm" in layout.description or kind.startswith("acircles")


@pytest.mark.parametrize("paper", [(297, 210), (210, 297)])
def test_staggered_circles_are_turned_and_not_mirrored(paper):
    """The next circle of a line, then the line after next: clockwise on paper, however it lies."""
    shapes = layout_of("acircles:4x10", paper).shapes
    first, following, below = (np.array([shapes[k].x, shapes[k].y]) for k in (0, 1, 8))
    (a, b), (c, d) = following - first, below - first
    assert a * d - b * c > 0 and abs(a * c + b * d) < 1e-9
    assert (abs(a) < 1e-9) == (paper[0] > paper[1])     # lines stand on a sheet that lies


@pytest.mark.parametrize("kind", cases(KINDS, longer=[
    "dots", "acircles:4x11", "acircles:5x7", "charuco:10x7", "charuco:5x9", "aprilgrid:6x4:0.3"]))
def test_our_detector_finds_every_point(pages, kind):
    layout, pdf, _ = pages(kind)
    points = detect_points([("page.png", painted(pdf, 3))], layout.target)
    assert points.count == points.whole == layout.points
    assert not points.photos[0].dropped
    assert points.target == kind.partition(":")[0]


@pytest.mark.parametrize("kind", ["acircles:4x11", "charuco:10x7", "chessboard:9x6",
                                  "aprilgrid:6x4"])
def test_opencv_finds_it_too(pages, kind):
    """Another one's idea of which circle or square is where."""
    import cv2
    layout, pdf, _ = pages(kind)
    image, (columns, rows) = painted(pdf, 3), map(int, kind.partition(":")[2].split("x"))
    if kind.startswith("acircles"):
        found, xy = cv2.findCirclesGrid(image, (columns, rows),
                                        flags=cv2.CALIB_CB_ASYMMETRIC_GRID)
    elif kind.startswith("chessboard"):
        found, xy = cv2.findChessboardCorners(image, (columns, rows))
    elif kind.startswith("aprilgrid"):
        settings = cv2.aruco.DetectorParameters()
        settings.markerBorderBits = 2
        tags, number, _ = cv2.aruco.ArucoDetector(cv2.aruco.getPredefinedDictionary(
            cv2.aruco.DICT_APRILTAG_36h11), settings).detectMarkers(image)
        xy = np.reshape(tags, (-1, 2))
        middle = {int(n): np.reshape(tag, (4, 2)).mean(axis=0) for n, tag in zip(number, tags)}
        # Kalibr's: 0 at the lower left, then to the right; OpenCV's pictures stand on their heads.
        order = sorted(middle, key=lambda n: (-middle[n][1].round(-1), middle[n][0]))
        first, _, third, _ = np.reshape(tags[0], (4, 2)).sum(axis=1)
        found = order == [*range(24)] and first > third
    else:
        board = cv2.aruco.CharucoBoard((columns, rows), 1, .75, cv2.aruco.getPredefinedDictionary(
            cv2.aruco.DICT_4X4_50))
        xy, number, _, _ = cv2.aruco.CharucoDetector(board).detectBoard(image)
        found = number is not None and list(number.ravel()) == list(range(layout.points))
    assert found and len(xy) == layout.points


def test_a_page_says_what_to_type_and_how_long_its_ruler_is(pages):
    svg = pages("chessboard:9x6")[2].decode()
    text = " ".join(re.findall(r"<text[^>]*>([^<]*)<", svg))
    assert "ncdc calibrate PHOTO... --target chessboard:9x6" in text
    assert "9 x 6 inner corners, squares of 24 mm" in text
    assert "100 mm if printed at 100 %" in text


@pytest.mark.parametrize("paper,size", [
    ("A3", (420, 297)), ("letter", (279.4, 215.9)), ("300x400mm", (300, 400)),
    ("125.5x300", (125.5, 300))])
def test_papers(tmp_path, capsys, paper, size):
    name = str(tmp_path / "page.svg")
    assert main(["target", "chessboard:5x4", "--paper", paper, "-o", name, "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["paper_mm"] == list(size) and report["points"] == 20
    sheet, polygons = shapes((tmp_path / "page.svg").read_bytes())
    assert sheet == pytest.approx(size, abs=1e-3)
    low, high = (edge([edge(p, axis=0) for p in polygons], axis=0) for edge in (np.min, np.max))
    assert (low >= 7.99).all() and (high <= np.array(size) - 7.99).all()


def test_a_step_that_is_asked_for(tmp_path, capsys):
    assert main(["target", "dots", "--step", "7.5", "-o", str(tmp_path / "page.pdf")]) == 0
    assert "37 columns x 23 rows of dots, 7.5 mm apart" in capsys.readouterr().out


def test_two_pages_are_identical(pages):
    layout, pdf, svg = pages("charuco:10x7")
    assert page(layout, "pdf") == pdf and page(layout, "svg") == svg


@pytest.mark.parametrize("arguments,said", [
    (["stars"], "the target is 'stars', one of dots, circles, acircles, chessboard, charuco, "
     "aprilgrid is"),
    (["dots:9x6"], "the target is 'dots:9x6', one of dots"),
    (["chessboard:2x6"], "has 2 columns and 6 rows, the limits are 3 and 200"),
    (["chessboard:9"], "target is 'chessboard:9', one of"),
    (["dots", "--paper", "A9"], "the paper is 'A9', one of A4, A3, Letter or WxHmm"),
    (["dots", "--paper", "100x300mm"], "the paper is 100x300 mm, the limits of a side are 120 and"),
    (["dots", "--paper", "nanx300mm"], "the paper is nanx300 mm, the limits of a side are 120"),
    (["dots", "--step", "0"], "the step is 0 mm, the limits are 1 and 500"),
    (["dots", "--step", "nan"], "the step is nan mm, the limits are 1 and 500"),
    (["dots", "--step", "100"], "dots with 100 mm between points does not fit on 297x210 mm"),
    (["chessboard", "--step", "26"], "does not fit on 297x210 mm: at most 24.9 mm do"),
    (["charuco:100x100"], "charuco:100x100 needs 5000 markers, DICT_4X4_1000 has 1000"),
    (["aprilgrid:30x20"], "aprilgrid:30x20 needs 600 tags, the family 36h11 has 587"),
    (["aprilgrid:6x6:3"], "has the spacing '3', a number from 0.05 to 1 is needed")])
def test_what_cannot_be(tmp_path, capsys, arguments, said):
    assert main(["target", *arguments, "-o", str(tmp_path / "page.pdf")]) == 2
    out, err = capsys.readouterr()
    assert said in err and err.count("\n") == 1 and not out
    assert not list(tmp_path.iterdir())


def test_an_output_is_a_file(tmp_path, capsys):
    (tmp_path / "page.pdf").mkdir()
    assert main(["target", "dots", "-o", str(tmp_path / "page.pdf")]) == 2
    assert capsys.readouterr().err.endswith("page.pdf: it is a folder\n")


def test_a_page_is_no_picture(tmp_path, capsys):
    assert main(["target", "dots", "-o", str(tmp_path / "page.png")]) == 2
    assert "a page is written as .pdf or .svg" in capsys.readouterr().err
