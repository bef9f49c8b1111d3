"""Maps and points for other software: OpenCV reads them and does what the hardware does."""

import csv

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.calibration.remap_source import load_remap
from ncdc_model.golden.corrector import correct
from ncdc_model.golden.network import frame_coordinates
from ncdc_model.remap_tables import SUFFIXES


@pytest.fixture
def net(tmp_path):
    camera = barrel_descriptor((96, 80), (90, 82), hidden_neurons=4, strength=.4,
                               fill=(10, 200, 30))
    camera.save(tmp_path / "net.toml")
    return camera


@pytest.fixture
def points(tmp_path):
    rng = np.random.default_rng(5)
    index = np.array([(i, j) for j in range(3) for i in range(4)])
    index = index[rng.permutation(12)]
    photos = [PhotoPoints(index, index * 20.0 + (30 + k, 40) + rng.uniform(-1, 1, (12, 2)),
                          np.zeros(12), name=name) for k, name in enumerate(("a.png", "b,1.png"))]
    TargetPoints("dots", (160, 120), tuple(photos)).save(tmp_path / "points.json")
    return TargetPoints.load(tmp_path / "points.json")


def read_tables(path):
    if path.suffix == ".npz":
        with np.load(path) as tables:
            return tables["map_x"], tables["map_y"]
    storage = cv2.FileStorage(str(path), cv2.FILE_STORAGE_READ)
    return storage.getNode("map_x").mat(), storage.getNode("map_y").mat()


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_tables_hold_the_coordinates_of_the_hardware(tmp_path, net, suffix):
    path = tmp_path / f"maps{suffix}"
    assert main(["export", str(tmp_path / "net.toml"), "-o", str(path)]) == 0
    blank = correct(net, np.zeros((82, 90), np.uint8)).blank
    assert .02 < blank.mean() < .5
    for table, raw in zip(read_tables(path), frame_coordinates(net)):
        assert table.dtype == np.float32
        scaled = table * 2**net.formats.coordinate.f_bits
        np.testing.assert_array_equal(scaled[~blank], raw[~blank])
        assert (table[blank] == -16).all()
    read = load_remap([path])
    assert read.geometry.distorted == (90, 82)
    for table, raw in zip((read.x, read.y), frame_coordinates(net)):
        on = np.isfinite(table)
        # A source within half a pixel of the sensor's edge is corrected, but not trained on.
        assert on.mean() > .9 and not (on & blank).any()
        np.testing.assert_array_equal(table[on], raw[on] / 2**net.formats.coordinate.f_bits)


def test_remap_with_the_tables_gives_the_corrected_picture(tmp_path, net):
    assert main(["export", str(tmp_path / "net.toml"), "-o", str(tmp_path / "maps.npz")]) == 0
    # Of one colour a row: no Bayer interpolation and no column error can hide.
    ramp = np.repeat(np.arange(82, dtype=np.uint8)[:, None] * 3, 90, axis=1)
    map_x, map_y = read_tables(tmp_path / "maps.npz")
    picture = cv2.remap(cv2.merge([ramp] * 3), map_x, map_y, cv2.INTER_LINEAR,
                        borderMode=cv2.BORDER_CONSTANT, borderValue=(10, 200, 30))
    ours = correct(net, ramp)
    assert (picture[ours.blank] == (10, 200, 30)).all()
    # Half a pixel from the sensor's edge the hardware still interpolates, remap fills in.
    inner = (map_x >= .5) & (map_x <= 88.5) & (map_y >= .5) & (map_y <= 80.5)
    assert inner.mean() > .5
    # Three grey levels a row: half a pixel would show. Green is the mean of a quad's two rows.
    assert np.abs(picture[..., 1].astype(int) - ours.picture[..., 1])[inner].max() <= 1


def test_points_for_opencv_calibrate_a_camera(tmp_path, points):
    path = tmp_path / "points.csv"
    assert main(["export", str(tmp_path / "points.json"), "-o", str(path)]) == 0
    rows = list(csv.DictReader(path.open()))
    assert len(rows) == points.count == 24
    assert {row["photo"] for row in rows} == {"a.png", "b,1.png"}
    by_index = {(name, int(row["object_x"]), int(row["object_y"])):
                (float(row["image_x"]), float(row["image_y"]))
                for row in rows for name in [row["photo"]]}
    for photo in points.photos:
        for (i, j), xy in zip(photo.index, photo.xy):
            np.testing.assert_allclose(by_index[photo.name, i, j], xy, atol=1e-4)
    assert all(row["object_z"] == "0" for row in rows)


def test_points_line_by_line(tmp_path, points):
    path = tmp_path / "lines.csv"
    assert main(["export", str(tmp_path / "points.json"), "--style", "discorpy", "-o",
                 str(path)]) == 0
    rows = [row for row in csv.DictReader(path.open()) if row["photo"] == "a.png"]
    assert [(row["direction"], row["line"]) for row in rows] == \
        [("horizontal", str(j)) for j in range(3) for _ in range(4)] + \
        [("vertical", str(i)) for i in range(4) for _ in range(3)]
    x, y = (np.array([float(row[axis]) for row in rows]) for axis in "xy")
    assert (np.diff(x[:12].reshape(3, 4)) > 15).all() and (np.diff(y[12:].reshape(4, 3)) > 15).all()


@pytest.mark.parametrize("arguments,message", [
    (["net.toml", "-o", "maps.bin"], "maps.bin: tables are written as one of .npz"),
    (["net.toml", "-o", "maps.npz", "--style", "opencv"], "style opencv is for points"),
    (["points.json", "-o", "points.npz"], "points.npz: points are written as .csv"),
    (["absent.toml", "-o", "maps.npz"], "cannot read absent.toml"),
    (["points.json", "-o", "points.json"], "would replace the input"),
])
def test_bad_exports_are_rejected(tmp_path, net, points, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    before = sorted(tmp_path.iterdir())
    assert main(["export", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert sorted(tmp_path.iterdir()) == before
