"""``ncdc calibrate`` from photo to points file, overlay and report."""

import argparse
import json
import subprocess
import sys

import cv2
import numpy as np
import pytest

from ncdc.cli import calibrate
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.example import example_camera, target_photo
from ncdc_model.images import read_image, write_image
from ncdc_spec.errors import InputError


def command(*words):
    parser = argparse.ArgumentParser()
    calibrate.add_arguments(parser)
    calibrate.run(parser.parse_args([str(word) for word in words]))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("photos")
    write_image(folder / "page.png", target_photo(example_camera()))
    write_image(folder / "blank.png", np.full((480, 640), 180, np.uint8))
    return folder


@pytest.mark.longer
def test_one_photo(folder, capsys):
    out = folder / "out" / "points.json"
    command(folder / "page.png", "--target", "dots", "-o", out, "--json", "-")
    report = json.loads(capsys.readouterr().out)
    points = TargetPoints.load(out)
    assert report["points_found"] == points.count > 300
    assert (report["columns"], report["rows"]) == (points.columns, points.rows) == (27, 20)
    assert report["photos_used"] == 1 and report["photos_rejected"] == {}
    assert report["points_rejected"] == sum(report["points_rejected_by_reason"].values()) > 0
    assert report["overlays"] == [str(out.with_name("points.overlay.png"))]
    assert read_image(out.with_name("points.overlay.png")).shape == (480, 640, 3)


@pytest.mark.longer
def test_unusable_photo_is_named_and_the_other_used(folder, capsys):
    out, report = folder / "both.json", folder / "report.json"
    command(folder / "blank.png", folder / "page.png", "-o", out, "--json", report)
    text = capsys.readouterr()
    assert "blank.png: not used: neither a whole grid of circles, a page of" in text.err
    assert "in 1 of 2 photos" in text.out
    assert list(json.loads(report.read_text())["photos_rejected"]) == [str(folder / "blank.png")]


def test_nothing_usable(folder):
    with pytest.raises(InputError, match="no photo shows the target"):
        command(folder / "blank.png", "--target", "dots", "-o", folder / "none.json")
    assert not (folder / "none.json").exists()
    with pytest.raises(InputError, match="cannot read .*absent.png"):
        command(folder / "absent.png", "-o", folder / "none.json")


@pytest.mark.longer
def test_photo_is_never_replaced(folder):
    before = (folder / "page.png").read_bytes()
    with pytest.raises(InputError, match="would replace the photo of that name"):
        command(folder / "page.png", "--target", "dots", "-o", folder / "page.png")
    write_image(folder / "own.overlay.png", target_photo(example_camera()))
    with pytest.raises(InputError, match="own.overlay.png would replace the photo of that name"):
        command(folder / "own.overlay.png", "--target", "dots", "-o", folder / "own.json")
    assert not (folder / "own.json").exists()
    command(folder / "page.png", "--target", "dots", "-o", folder / "page.json")
    assert (folder / "page.json").exists() and (folder / "page.overlay.png").exists()
    assert (folder / "page.png").read_bytes() == before


def test_what_is_said_of_a_photo_is_said_once(folder, capsys):
    cv2.imwrite(str(folder / "deep.png"), target_photo(example_camera()).astype(np.uint16) * 16)
    command(folder / "deep.png", "--target", "dots", "-o", folder / "deep.json")
    assert capsys.readouterr().err.count("deep.png has 16-bit samples") == 1


def test_nothing_but_our_sentences_on_stderr(tmp_path):
    """Markers so large make OpenCV's board write warnings."""
    family = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
    board = cv2.aruco.GridBoard((5, 4), 1.0, 0.1, family)
    photo, out = tmp_path / "markers.png", tmp_path / "points.json"
    write_image(photo, board.generateImage((600, 490), marginSize=30))
    result = subprocess.run([sys.executable, "-c", "from ncdc.cli import main; raise SystemExit("
                             f"main(['calibrate', {str(photo)!r}, '-o', {str(out)!r}]))"],
                            capture_output=True, text=True)
    lines = [line for line in result.stderr.splitlines() if not line.startswith("calibrate: ")]
    assert result.returncode == 2 and len(lines) == 1 and not out.exists()
    assert "it shows 20 markers of the family 4X4_1000 but no ChArUco board" in lines[0]


def test_another_target_is_rejected_and_the_earlier_file_stays(folder):
    out = folder / "earlier.json"
    out.write_text("earlier")
    with pytest.raises(InputError, match=r"it shows \d+ circles or dots, \d+ columns by \d+ rows, "
                                         r"not a grid of 4x11"):
        command(folder / "page.png", "--target", "circles:4x11", "-o", out)
    assert out.read_text() == "earlier"


@pytest.mark.longer
def test_dropped_points_are_listed_with_position_and_reason(folder, capsys):
    page = target_photo(example_camera())
    spot = read_image(folder / "page.png")[236:262, 300:340].min(axis=0).argmin() + 300
    page[230:262, spot - 3:spot + 3] = np.minimum(page[230:262, spot - 3:spot + 3], 40)
    write_image(folder / "marked.png", page)
    command(folder / "marked.png", "-o", folder / "dropped.json", "--json", "-")
    captured = capsys.readouterr()
    report = json.loads(captured.out)
    dropped = report["points_dropped"]
    assert all(set(point) == {"photo", "x", "y", "reason"} for point in dropped)
    assert report["target_chosen"] == "dots, which 1 of 1 photos show"
    assert 0 < report["agreement_px"]["marked.png"] < 0.1
    assert "calibrate: " in captured.err and "smooth lens" in captured.err
