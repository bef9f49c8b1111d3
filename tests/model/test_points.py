"""The points file: round trip, and every check on loading."""

import json

import numpy as np
import pytest

from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_spec.errors import InputError


def photo(columns=4, rows=3, name="a.png", shift=0.0):
    i, j = np.meshgrid(np.arange(columns), np.arange(rows))
    index = np.stack([i.ravel(), j.ravel()], axis=1)
    return PhotoPoints(index=index, xy=10.123 * index + 5 + shift, area=np.full(len(index), 12.5),
                       rejected={"cut by the border": 3}, name=name)


@pytest.fixture
def path(tmp_path):
    photos = photo(), photo(3, 4, "b.png", 0.5)
    points = TargetPoints("dots", (64, 48), photos, {"c.png": "blank"})
    points.save(tmp_path / "points.json")
    return tmp_path / "points.json"


def test_round_trip(path):
    points = TargetPoints.load(path)
    assert (points.target, points.size, points.count) == ("dots", (64, 48), 24)
    assert (points.columns, points.rows) == (4, 4)
    assert points.rejected_photos == {"c.png": "blank"}
    first, expected = points.photos[0], photo()
    np.testing.assert_array_equal(first.index, expected.index)
    np.testing.assert_allclose(first.xy, expected.xy, atol=1e-4)
    assert (first.name, first.rejected, first.area[0]) == ("a.png", expected.rejected, 12.5)
    before = path.read_bytes()
    points.save(path)
    assert path.read_bytes() == before


def test_digest_follows_the_points(path):
    points = TargetPoints.load(path)
    assert points.digest == TargetPoints.load(path).digest and len(points.digest) == 12
    moved = PhotoPoints(points.photos[0].index, points.photos[0].xy + 1e-3, points.photos[0].area)
    assert TargetPoints("dots", (64, 48), (moved, points.photos[1])).digest != points.digest


def set_point(row):
    def change(table):
        table["photos"][0]["points"][1] = row
    return change


@pytest.mark.parametrize("change,error", [
    (lambda t: t.update(version=9), "has points version 9, version 1 is needed"),
    (lambda t: t.update(format="other"), "is no points file"),
    (lambda t: t.pop("target"), "lacks the value 'target'"),
    (lambda t: t.update(target="stars"),
     "target is 'stars', one of dots, circles, acircles, chessboard"),
    (lambda t: t.update(columns=7), "columns and rows are 7 and 4, the indices span 4 and 4"),
    (lambda t: t.update(width=2), "image size is 2x48, the limits are 8 and 4096"),
    (lambda t: t.update(width="x"), "holds a value of the wrong kind"),
    (lambda t: t.update(photos=[]), "points of 0 photos, at least 1 is needed"),
    (set_point([1, 0, 20.0, 5.0]), "a point needs 5 numbers"),
    (set_point([1, 0, 20.0, 5.0, 1.0, 2]), "the sixth number of a point must be 0 or 1"),
    (set_point([0, 0, 20.0, 5.0, 1.0]), "a.png: 12 points have 11 different indices"),
    (set_point([0.5, 0, 20.0, 5.0, 1.0]), "a.png: an index is no whole number"),
    (set_point([1, 0, 64.0, 5.0, 1.0]), r"point \(64, 5\) lies outside the image of 64x48"),
    (set_point([1, 0, -1.0, 5.0, 1.0]), r"point \(-1, 5\) lies outside the image"),
    (set_point([1, 0, float("nan"), 5.0, 1.0]), "a.png: xy holds a number that is not finite"),
    (set_point([1, 0, 20.0, 5.0, float("inf")]), "a.png: area holds a number that is not finite"),
])
def test_bad_values_are_rejected(path, change, error):
    table = json.loads(path.read_text())
    change(table)
    path.write_text(json.dumps(table))
    with pytest.raises(InputError, match=error):
        TargetPoints.load(path)


@pytest.mark.parametrize("text", ["", "{", "[1, 2]", "\"points\""])
def test_files_that_are_no_points(path, text):
    path.write_text(text)
    with pytest.raises(InputError, match="is no points file"):
        TargetPoints.load(path)


def test_absent_file(tmp_path):
    with pytest.raises(InputError, match="cannot read .*absent.json: No such file"):
        TargetPoints.load(tmp_path / "absent.json")
