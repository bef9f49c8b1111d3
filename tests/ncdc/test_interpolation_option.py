"""An interpolation chosen at training reaches every later command."""

import json

import numpy as np
import pytest

from ncdc.cli import main
from ncdc_model.golden.corrector import correct
from ncdc_model.images import read_image, write_image
from ncdc_model.lens import Camera
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.interpolation import DIRECTIONAL, FAST

pytestmark = pytest.mark.longer


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("directional")
    Camera.from_dict({"width": 64, "height": 48, "radial": "kb", "f_distorted": 40.0,
                      "centre": [31.5, 23.5]}).save(
        path / "camera.toml")
    for name, options in ("net", []), ("fast", ["--interpolation", "fast"]):
        assert main(["train", str(path / "camera.toml"), "--neurons", "2", *options,
                     "-o", str(path / f"{name}.toml")]) == 0
    return path


def test_the_default_is_in_the_descriptor_and_correct_follows_it(folder):
    descriptor = Descriptor.load(folder / "net.toml")
    assert descriptor.geometry.interpolation == DIRECTIONAL
    assert 'interpolation = "directional"' in (folder / "net.toml").read_text()
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


@pytest.mark.parametrize("command,image,out", [("generate", [], "hw"),
                                               ("simulate", ["zeros.png"], "out.png")])
def test_multiport_rejects_it_in_one_sentence(folder, command, image, out, capsys):
    write_image(folder / "zeros.png", np.zeros((48, 64), np.uint8))
    assert main([command, str(folder / "net.toml"), *(str(folder / name) for name in image), "-o",
                 str(folder / out), "--fetch", "multiport"]) == 2
    assert capsys.readouterr().err == (
        f"ncdc {command}: the descriptor's interpolation is directional, the multiport fetcher can "
        f"have fast only, which ncdc train --interpolation fast gives\n")
    assert not (folder / out).exists()


def test_what_the_sentence_names_is_what_multiport_takes(folder):
    assert Descriptor.load(folder / "fast.toml").geometry.interpolation == FAST
    assert main(["generate", str(folder / "fast.toml"), "-o", str(folder / "paper"), "--fetch",
                 "multiport"]) == 0
    assert "read2_readdata" in (folder / "paper" / "ncdc.v").read_text()
