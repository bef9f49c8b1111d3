"""``ncdc bench model``: its rows on small frames, and what ends it with status 1."""

import json

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_bench.model import command, measure
from ncdc_model.compiled.corrector import CompiledCorrector
from ncdc_spec.interpolation import INTERPOLATIONS


@pytest.fixture
def small(monkeypatch):
    """The bench on frames of 64x48 pixels, of a scene and a lens that take no time."""
    def lens_of(size, interpolation):
        return barrel_descriptor(size, size, interpolation=interpolation)
    monkeypatch.setattr(measure, "lens_of", lens_of)
    scene = np.random.default_rng(1).uniform(0, 255, (48, 64, 3))
    monkeypatch.setattr(measure, "scene_light", lambda camera: scene)
    monkeypatch.setattr(measure, "_DEVICE", (64, 48))
    monkeypatch.setattr(command, "SIZES", [(64, 48)])


def test_both_models_are_measured(small, tmp_path, capsys):
    path = tmp_path / "model.json"
    main(["bench", "model", "--json", str(path)])       # so small a frame may take too long
    report = json.loads(path.read_text())
    assert [(row["size"], row["interpolation"], row["model"]) for row in report["rows"]] == [
        ("64x48", name, model) for name in INTERPOLATIONS for model in ("reference", "compiled")]
    for row in report["rows"]:
        assert row["bits_different"] == 0
        assert min(row[name] for name in ("milliseconds", "map_milliseconds",
                                          "opencv_milliseconds")) > 0
    assert report["device"]["frames_per_second"] > 0
    assert "bits different" in capsys.readouterr().out


def test_a_different_bit_ends_it_with_status_1(small, monkeypatch, capsys):
    picture = CompiledCorrector.picture

    def wrong(self, raw, crest=0):
        found = picture(self, raw, crest)
        found[0, 0, 0] ^= 3
        return found
    monkeypatch.setattr(CompiledCorrector, "picture", wrong)
    assert main(["bench", "model"]) == 1
    assert "64x48 fast compiled: 2 bits differ" in capsys.readouterr().err


def test_a_slow_model_ends_it_with_status_1(small, monkeypatch, capsys):
    monkeypatch.setattr(command, "LIMIT", 0)
    assert main(["bench", "model"]) == 1
    assert "64x48 fast compiled: " in capsys.readouterr().err


def test_the_network_is_scaled_to_the_size(monkeypatch):
    """A lens of twice the size has the same picture, twice as large."""
    base = barrel_descriptor((640, 480), (640, 480))
    monkeypatch.setattr(measure, "trained", lambda lens: base)
    pair = [measure.lens_of(size, INTERPOLATIONS["gradient"]) for size in ((320, 240), (640, 480))]
    assert [d.geometry.corrected for d in pair] == [(320, 240), (640, 480)]
    small, large = ((d.network(0.3, -0.2)[0] + .5) / d.geometry.distorted_width for d in pair)
    np.testing.assert_allclose(small, large)
    assert not pair[0].valid.mask(320).all()
