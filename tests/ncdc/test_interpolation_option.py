"""An interpolation chosen at training reaches every later command."""

import json

import numpy as np
import pytest

from ncdc.cli import main
from ncdc_model.corrector import correct
from ncdc_model.descriptor import Descriptor
from ncdc_model.images import read_image, write_image
from ncdc_model.interpolation import GRADIENT
from ncdc_model.lens import Camera


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("gradient")
    Camera.from_dict({"width": 64, "height": 48, "radial": "kb", "f_distorted": 40.0,
                      "centre": [31.5, 23.5]}).save(
        path / "camera.toml")
    assert main(["train", str(path / "camera.toml"), "--neurons", "2", "--interpolation",
                 "gradient", "-o", str(path / "net.toml")]) == 0
    return path


def test_the_descriptor_names_it_and_correct_follows_it(folder):
    descriptor = Descriptor.load(folder / "net.toml")
    assert descriptor.geometry.interpolation == GRADIENT
    raw = np.random.default_rng(1).integers(0, 256, (48, 64), np.uint8)
    write_image(folder / "raw.png", raw)
    assert main(["correct", str(folder / "net.toml"), str(folder / "raw.png"), "-o",
                 str(folder / "corrected.png")]) == 0
    np.testing.assert_array_equal(read_image(folder / "corrected.png"),
                                  correct(descriptor, raw).picture)


def test_the_planner_counts_its_tiles(folder, capsys):
    assert main(["plan", str(folder / "net.toml"), "--json", "-"]) == 0
    report = json.loads(capsys.readouterr().out)
    tile_bytes = 32
    pixels = 64 * 48
    assert report["bytes_read_per_pixel"] == pytest.approx(report["misses"] * tile_bytes / pixels)


def test_multiport_refuses_it_in_one_sentence(folder, capsys):
    assert main(["generate", str(folder / "net.toml"), "-o", str(folder / "hw"), "--fetch",
                 "multiport"]) == 2
    assert ("the descriptor's interpolation is gradient, the multiport fetcher can have fast only"
            in capsys.readouterr().err)
    assert not (folder / "hw").exists()
