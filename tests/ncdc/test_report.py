"""``ncdc report``: one page on a camera, and its lens in words."""

import base64
import json
import re
from dataclasses import replace
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest

from lenses import lens
from ncdc.cli import main
from ncdc.report.lens_words import lens_rows
from ncdc_model.calibration.points import TargetPoints
from ncdc_model.correction import correct
from ncdc_model.images import read_image, write_image
from ncdc_model.lens import BrownWeng, TiltedSensor
from quick_lenses import SIZE, quick_descriptor, save_points


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """``net.toml``, its ``points.json``, and the photo of these."""
    monkeypatch.chdir(tmp_path)
    save_points("points.json")
    write_image("page.png", cv2.GaussianBlur(np.random.default_rng(1).integers(
        0, 256, SIZE[::-1], np.uint8), (0, 0), 2))
    descriptor = quick_descriptor("points.json", errors={
        "region": {"map_error_fixed_px": {"mse": .01, "mean": .0625, "max": .375}}})
    descriptor.save("net.toml")
    return descriptor


class Page(HTMLParser):
    """Headings, cells and addresses of a page."""

    def __init__(self, path):
        super().__init__()
        self.headings, self.cells, self.sources, self.open = [], [], [], ""
        self.feed(path.read_text())

    def handle_starttag(self, tag, attributes):
        self.open = tag
        self.sources += [value for name, value in attributes if name in ("src", "href")]

    def handle_data(self, data):
        {"h2": self.headings, "td": self.cells}.get(self.open, []).append(data)
        self.open = ""


def picture(uri):
    content = np.frombuffer(base64.b64decode(uri.partition(",")[2]), np.uint8)
    return cv2.imdecode(content, cv2.IMREAD_COLOR)[:, :, ::-1]


@pytest.mark.longer
def test_the_page(folder, tmp_path, capsys):
    assert main(["report", "net.toml", "-o", "out.html", "--json", "report.json"]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["lens_words"]["Focal length"][0] in (tmp_path / "out.html").read_text()
    page = Page(tmp_path / "out.html")
    assert page.headings == ["Before and after", "Calibration", "The lens", "Accuracy", "Hardware",
                             "Go on"]
    # Nothing is fetched from anywhere.
    assert all(re.match("data:image/(jpeg|png);base64,", source) for source in page.sources)
    before, after, points, *maps = map(picture, page.sources)
    raw = read_image("page.png")
    assert before.shape == after.shape == points.shape == (*SIZE[::-1], 3) and len(maps) == 2
    wanted = correct(folder, raw).picture
    assert np.abs(after - wanted.astype(float)).mean() < 8 < np.abs(
        before - wanted.astype(float)).mean()
    cells = page.cells
    assert cells[cells.index("region") + 1:][:2] == ["0.0625", "0.3750"]
    assert float(cells[cells.index("Focal length") + 1].split()[0]) == pytest.approx(165, abs=2)
    assert abs(float(cells[cells.index("Roll") + 1].split()[0])) == pytest.approx(2, abs=.3)
    assert cells[cells.index("Page") + 1] == "flat" and "±" in cells[cells.index("Tilt") + 1]
    assert {"sdram", "ddr3"} <= set(cells)
    assert "ncdc correct net.toml page.png" in (tmp_path / "out.html").read_text()
    assert "warning" not in capsys.readouterr().err


def test_without_calibration_and_photo(folder, tmp_path, monkeypatch, capsys):
    # The other test has the planner's figures, which take seconds.
    monkeypatch.setattr("ncdc.cli.report.hardware_section", lambda *_: {"title": "Hardware"})
    (tmp_path / "points.json").unlink()
    assert main(["report", "net.toml", "-o", "out.html"]) == 0
    assert Page(tmp_path / "out.html").headings == ["Hardware", "Go on"]
    error = capsys.readouterr().err
    assert "points.json is not there: --calibration names" in error and "--photo names" in error


def test_bad_input(folder, tmp_path, capsys):
    (tmp_path / "out.html").write_text("kept")
    points = TargetPoints.load("points.json")
    moved = replace(points.photos[0], xy=points.photos[0].xy + .25)
    replace(points, photos=(moved,)).save("other.json")
    for arguments, message in [
            (["--calibration", "other.json"], "other.json holds other points than those that"),
            (["--calibration", "missing.json"], "cannot read missing.json"),
            (["--photo", "points.json"], "points.json is a points file"),
            (["--photo", "missing.png"], "cannot read missing.png")]:
        assert main(["report", "net.toml", "-o", "out.html", *arguments]) == 2
        assert message in capsys.readouterr().err
    assert (tmp_path / "out.html").read_text() == "kept"


@pytest.mark.parametrize("name", ["net.toml", "points.json", "page.png"])
def test_no_input_is_replaced(folder, tmp_path, name, capsys):
    """Neither one that is named, nor one that is found."""
    before = (tmp_path / name).read_bytes()
    assert main(["report", "net.toml", "-o", name]) == 2
    assert f"the input {name}" in capsys.readouterr().err
    assert (tmp_path / name).read_bytes() == before


def rows_of(camera):
    return {what: (figure, words) for what, figure, words in lens_rows(camera)}


def test_a_lens_in_words():
    rows = rows_of(lens())
    assert rows["Focal length"][0] == "165.0 px"
    assert rows["Axis"] == ("(161.5, 117.8)",
                            "it meets the picture 2.0 px right of and 1.7 px above its middle")
    a, b = lens().undistort(np.array([0, 319.0]), np.array([119.5] * 2))
    angle = np.degrees(np.arctan(np.hypot(a, b))).sum()
    assert rows["Field of view"][0] == f"{angle:.0f}° across"
    assert rows["Distortion"][0].startswith("-") and "barrel" in rows["Distortion"][1]
    assert rows["Tilt"][0] == "none" and "Pixels" not in rows


def test_flaws_in_words():
    plain = replace(lens(), decentring=BrownWeng())
    assert rows_of(plain)["Decentring"] == ("0.00 px", "the elements of the lens are on one axis")
    effect = float(re.search(r"[\d.]+", rows_of(lens())["Decentring"][0])[0])
    twice = float(re.search(r"[\d.]+", rows_of(replace(lens(), decentring=BrownWeng(
        p=(-.0012, .002))))["Decentring"][0])[0])
    assert effect > .2 and twice == pytest.approx(2 * effect, rel=.1)
    tilted = rows_of(replace(plain, tilt=TiltedSensor((.03, -.04)), aspect=1.01))
    assert tilted["Tilt"][0] == f"{np.degrees(.05):.2f}°"
    assert tilted["Pixels"] == ("1.0100", "a pixel is 1.00 % wider than high")


def test_a_lens_that_sees_behind_itself():
    wide = replace(lens(), focal=80.0)
    assert rows_of(wide)["Field of view"][0] == "180° or more across"
    assert rows_of(wide)["Distortion"][0] == "fisheye"
