"""``ncdc train`` on maps from elsewhere: stereo rectification, tables of ``ncdc export``."""

import json
from functools import partial

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from commands import call
from ncdc.cli import evaluate, main, train
from ncdc_model.evaluate import fixed_map
from ncdc_model.training.levenberg import train_levenberg
from ncdc_model.training.train import TRAINERS
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.interpolation import GRADIENT
from stereo import stereo_maps

SIZE = 192, 144


@pytest.fixture
def few_starts(monkeypatch):
    monkeypatch.setitem(TRAINERS, "lm", partial(train_levenberg, starts=9, rounds=0))


@pytest.mark.longer
def test_an_exported_map_becomes_the_network_that_it_came_from(tmp_path, few_starts, capsys,
                                                               monkeypatch):
    monkeypatch.chdir(tmp_path)
    camera = barrel_descriptor((96, 80), (90, 82), hidden_neurons=4, strength=.4,
                               interpolation=GRADIENT)
    camera.save("net.toml")
    assert main(["export", "net.toml", "-o", "maps.npz"]) == 0
    assert main(["train", "maps.npz", "--neurons", "4", "-o", "again.toml"]) == 0
    assert "the map reads columns" in capsys.readouterr().err
    again = Descriptor.load("again.toml")
    assert again.provenance["source"] == "maps.npz"
    assert again.provenance["source_kind"] == "remap tables, float32"
    v, u = np.indices((80, 96))
    (x, y), (a, b) = (fixed_map(net)(u, v) for net in (camera, again))
    valid = camera.geometry.window_inside(x, y) & camera.valid.mask(96)
    assert .8 < valid.mean() < .98
    np.testing.assert_array_equal(again.valid.mask(96), valid)
    assert np.hypot(x - a, y - b)[valid].max() < .02
    assert main(["evaluate", "again.toml", "--reference", "maps.npz", "--json", "report.json"]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["measured_on"] == "frame, map" and report["map_error_fixed_px"]["max"] < .02
    assert report["valid_pixels"] == valid.sum() and report["valid_pixels_differ"] == 0
    # What hides in the blank of one of the two does not count as agreement.
    camera.save("net.toml")
    assert main(["evaluate", "net.toml", "--reference", "maps.npz", "--json", "report.json"]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["valid_pixels_differ"] == (camera.valid.mask(96) != valid).sum() > 50
    assert report["map_error_fixed_px"]["max"] == 0


@pytest.mark.longer
def test_a_camera_of_a_stereo_pair_as_tiff_files(tmp_path, few_starts, capsys):
    x, y = stereo_maps(*SIZE, alpha=1)[1]
    paths, out = [tmp_path / f"right_{axis}.tif" for axis in "xy"], tmp_path / "net.toml"
    assert all(cv2.imwrite(str(path), table) for path, table in zip(paths, (x, y)))
    call(train, *paths, "--sensor-size", "192x144", "--neurons", 5, "-o", out, "--json",
         tmp_path / "r.json")
    output = capsys.readouterr()
    assert "warning: " in output.err and "beyond a sensor of 192x144" in output.err
    report, net = json.loads((tmp_path / "r.json").read_text()), Descriptor.load(out)
    valid = net.valid.mask(SIZE[0])
    v, u = np.nonzero(valid)
    a, b = fixed_map(net)(u, v)
    # Compared with OpenCV's own tables, and on no pixel without a source in the sensor.
    error = np.hypot(a - x[valid], b - y[valid])
    assert error.max() == pytest.approx(report["frame"]["map_error_fixed_px"]["max"], abs=1e-3)
    assert error.max() < 3 and .5 < valid.mean() < .8
    assert net.geometry.window_inside(x, y)[valid].all()
    call(evaluate, "--reference", paths[0], "--reference", paths[1], out)
    assert "measured on frame, map" in capsys.readouterr().out


@pytest.mark.longer
def test_the_neurons_of_a_map_are_chosen_by_its_whole_frame(tmp_path, few_starts, capsys):
    x, y = stereo_maps(*SIZE)[0]
    np.savez(tmp_path / "map.npz", map_x=x, map_y=y, sensor=SIZE)
    for name in ("1.toml", "2.toml"):
        call(train, tmp_path / "map.npz", "--neurons", "auto", "--max-error", 1, "-o",
             tmp_path / name)
    net = Descriptor.load(tmp_path / "1.toml")
    assert 3 <= net.hidden_neurons <= 6 and net.errors["measured_on"] == "frame"
    v, u = np.nonzero(net.valid.mask(SIZE[0]))
    a, b = fixed_map(net)(u, v)
    assert np.hypot(a - x[v, u], b - y[v, u]).max() <= 1
    assert (tmp_path / "1.toml").read_bytes() == (tmp_path / "2.toml").read_bytes()
    assert (tmp_path / "1.neurons.png").exists()
    assert "numbers tried, by the largest error on the whole frame" in capsys.readouterr().out


@pytest.mark.parametrize("arguments,message", [
    (["train", "x.tif", "y.tif", "--neurons", "4"], "the size of the sensor is not known"),
    (["train", "x.tif", "y.tif", "--neurons", "4", "--sensor-size", "192"],
     "sensor size is '192', WxH is"),
    (["train", "x.tif", "y.tif", "--neurons", "4", "--sensor-size", "192x144", "-o", "y.tif"],
     "would replace the input y.tif"),
    (["train", "x.tif", "y.tif", "--neurons", "4", "--sensor-size", "192x144", "--zoom", "fill"],
     "size and zoom choose the frame of points and camera files, the map of x.tif has its own"),
    (["train", "photo.png", "--neurons", "4"], "photo.png is a picture, points, a camera file or"),
    (["train", "camera.toml", "--neurons", "4", "--sensor-size", "320x240"],
     "camera.toml: the camera is for 320x200 pixels, the sensor has 320x240"),
    (["evaluate", "net.toml", "--reference", "x.tif", "--reference", "y.tif"],
     "x.tif and y.tif is the map of a corrected picture with 192x144 pixels, the descriptor is "
     "for 96x80"),
    (["evaluate", "net.toml", "--reference", "other.npz"],
     "the sensor has 200x150 pixels, the map of other.npz is for 192x144")])
def test_bad_calls_are_one_sentence(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    x, y = stereo_maps(*SIZE)[0]
    assert cv2.imwrite("x.tif", x) and cv2.imwrite("y.tif", y)
    assert cv2.imwrite("photo.png", np.zeros((20, 30, 3), np.uint8))
    np.savez("other.npz", map_x=x, map_y=y, sensor=SIZE)
    (tmp_path / "camera.toml").write_text(
        "width = 320\nheight = 200\nf_distorted = 200.0\ncentre = [160.0, 100.0]\n")
    barrel_descriptor((96, 80), (200, 150), hidden_neurons=3, strength=.4).save("net.toml")
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert message in error and error.count("\n") == 1
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


@pytest.mark.regress
@pytest.mark.parametrize("side", ["left", "right"])
def test_stereo_pair_to_a_tenth_of_a_pixel(tmp_path, side):
    x, y = stereo_maps(1280, 1024)[side == "right"]
    np.savez(tmp_path / "map.npz", map_x=x, map_y=y, sensor=(1280, 1024))
    call(train, tmp_path / "map.npz", "--neurons", "auto", "-o", tmp_path / "net.toml")
    net = Descriptor.load(tmp_path / "net.toml")
    v, u = np.nonzero(net.geometry.window_inside(x, y))
    a, b = fixed_map(net)(u, v)
    assert len(u) > .999 * x.size and np.hypot(a - x[v, u], b - y[v, u]).max() <= .1
