"""What the commands say of the picture beyond the outermost points, and leave out of it."""

import json
from functools import partial

import numpy as np
import pytest

from lenses import lens
from ncdc.cli import main
from ncdc.lot.work import Request, process
from ncdc_model.calibration.points import PhotoPoints, TargetPoints
from ncdc_model.training import region
from ncdc_model.training.choose import choose_camera
from ncdc_model.training.levenberg import train_levenberg
from ncdc_model.training.source import load_source
from ncdc_model.training.train import TRAINERS
from ncdc_spec.descriptor import Descriptor

SIZE = 320, 240


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    """``points.json``, of a page that covers the right part of the picture; quick trainings."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setitem(TRAINERS, "lm", partial(train_levenberg, starts=4, rounds=0))
    monkeypatch.setattr(region, "_STEP", 48)
    monkeypatch.setattr(region, "_BORDER", 400)
    grid = np.stack(np.meshgrid(np.arange(20), np.arange(19)), axis=-1).reshape(-1, 2)
    flat = .09 * grid - (.1, .8)
    x, y = lens().distort(*(flat / (1 + flat @ (.05, -.03))[:, None]).T)
    xy = np.stack([x, y], axis=1) + np.random.default_rng(1).normal(0, .02, (len(grid), 2))
    on = (xy > 3).all(axis=1) & (xy < np.array(SIZE) - 4).all(axis=1)
    photo = PhotoPoints(grid[on], xy[on], np.zeros(on.sum()), {}, "page.png")
    TargetPoints("chessboard", SIZE, (photo,)).save("points.json")


def trained(*options):
    line = "train points.json --neurons 4 -o net.toml --json report.json"
    assert main([*line.split(), *options]) == 0
    return json.loads(open("report.json").read()), Descriptor.load("net.toml")


@pytest.mark.longer
def test_train_warns_and_leaves_out_what_is_less_certain(capsys):
    report, descriptor = trained()
    sentence = next(text for text in report["warnings"] if "beyond the outermost points" in text)
    share = float(sentence.partition(" % of the picture lies")[0])
    assert share == pytest.approx(report["beyond_points_percent"], abs=.6)
    assert "most of it on the left; its error is not known better than" in sentence
    assert f"warning: {sentence}" in capsys.readouterr().err
    known = report["beyond_points_known_px"]
    assert known > 1 and report["map_error_fixed_px"]["max"] > known / 2
    less, blanked = trained("--blank-beyond", f"{known / 8:g}")
    assert less["blank_beyond_px"] == pytest.approx(known / 8, rel=1e-3)
    assert .7 * known / 8 < less["beyond_points_known_px"] < 1.2 * known / 8
    width = descriptor.geometry.corrected_width
    all_pixels, pixels = (each.valid.mask(width) for each in (descriptor, blanked))
    assert .3 * all_pixels.sum() < pixels.sum() < .95 * all_pixels.sum()
    # The left is blank, and nothing else is changed.
    assert (all_pixels & ~pixels)[:, :width // 2].sum() > .7 * (all_pixels & ~pixels).sum()
    assert np.abs(blanked.hidden_weights - descriptor.hidden_weights).max() < 5


@pytest.mark.parametrize("limit, message", [
    ("0", "--blank-beyond is 0, a positive number of pixels is needed"),
    ("nan", "--blank-beyond is nan, a positive number of pixels is needed"),
    ("1e-7", "% of the corrected frame is known to 1e-07 px or better, 5 % is the limit")])
def test_bad_limits(tmp_path, limit, message, capsys):
    (tmp_path / "net.toml").write_text("kept")
    assert main(["train", "points.json", "--neurons", "2", "-o", "net.toml", "--blank-beyond",
                 limit]) == 2
    assert message in capsys.readouterr().err
    assert (tmp_path / "net.toml").read_text() == "kept"


def test_a_camera_file_has_nothing_to_blank(capsys):
    lens().save("camera.toml")
    assert main(["train", "camera.toml", "--blank-beyond", "1"]) == 2
    assert "--blank-beyond is for points, camera.toml holds" in capsys.readouterr().err


@pytest.mark.longer
def test_the_report_and_the_lot_warn(monkeypatch, capsys):
    report, descriptor = trained()
    sentence = report["warnings"][-1]
    monkeypatch.setattr("ncdc.cli.report.hardware_section", lambda *_: {"title": "Hardware"})
    assert main(["report", "net.toml", "-o", "out.html", "--json", "page.json"]) == 0
    words = sentence.partition("%")[2].partition(";")[0]        # its valid pixels are the network's
    assert words in json.loads(open("page.json").read())["warnings"][-1]
    assert words in open("out.html").read()
    points = TargetPoints.load("points.json")
    monkeypatch.setattr("ncdc.lot.work.detect_points", lambda images, target: points)
    monkeypatch.setattr("ncdc.lot.work._first_picture", lambda *_: b"")
    monkeypatch.setattr("ncdc.lot.work._shown", lambda *_: np.zeros((240, 320, 3), np.uint8))
    monkeypatch.setattr("ncdc.lot.work._image", lambda *_: np.zeros((240, 320), np.uint8))
    open("page.png", "wb").write(b"page")
    done = process(["page.png"], Request("chessboard", neurons=4))
    assert not done.error and done.warnings.count(sentence) == 1


@pytest.mark.longer
def test_auto_is_judged_by_what_networks_can_learn():
    chosen = choose_camera(load_source("points.json"), goal=1.3)
    report = chosen.report
    assert report["max_error_met"] and report["hidden_neurons"] < 8
    assert report["map_error_fixed_px"]["max"] > 1.3
    assert "the network meets 1.3 px at the held-out points" in report["warnings"][-1]
