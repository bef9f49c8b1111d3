"""``ncdc bench view``: its figures on a small lens, and errors that it must see."""

import json
from dataclasses import replace

import numpy as np
import pytest

from ncdc.cli import main
from ncdc_bench.view import command, measure
from ncdc_bench.view.clocks import clocks_of
from ncdc_bench.view.command import complaints
from ncdc_bench.view.measure import row_of
from ncdc_bench.view.shaking import Shake, small_camera
from ncdc_bench.view.steadiness import steadiness, trained_lens
from ncdc_model.stabilise.quaternions import matrices, multiply
from ncdc_model.stabilise.stabiliser import Stabiliser
from plane_lens import seen_lens

STILL = {"moved_px_rms": 0.0, "moved_px_rms_hardware": 0.0}


@pytest.fixture(scope="module")
def small():
    return small_camera(), trained_lens(small_camera())


def test_views_are_within_their_limits():
    row = row_of("small", seen_lens(), 20)
    assert (row["views"], row["pixels"]) == (20, 20 * 8 * 96)
    assert 0 < row["lens_error_max_px"] <= row["map_error_max_px"]
    assert complaints([row], STILL) == []


@pytest.mark.parametrize("slip,word", [
    (lambda x, y, valid: (x + 13, y, valid), "off by"),
    (lambda x, y, valid: (x, y, np.roll(valid, 3, axis=1)), "filled without a source"),
    (lambda x, y, valid: (x, y, valid & (np.arange(96) != 48)), "blank with a source")])
def test_slips_of_the_model_are_seen(monkeypatch, slip, word):
    right = measure.view_coordinates
    monkeypatch.setattr(measure, "view_coordinates", lambda *args: slip(*right(*args)))
    assert any(word in text for text in complaints([row_of("small", seen_lens(), 5)], STILL))


def test_clocks_and_pixels_that_are_off_are_seen():
    row = {"lens": "one", "map_error_max_px": 0, "lens_error_max_px": 0, "wrongly_filled": 0,
           "wrongly_blank": 0, "clocks_per_pixel": 1.0, "predicted_clocks_per_pixel": 1.02,
           "bound_clocks_per_pixel": 1.03, "random_clocks_per_pixel": 1.031, "pixels_different": 3}
    assert [text.partition(" ")[2] for text in complaints([row], STILL)] == [
        "1.020 of the clocks are predicted, 1 % off is the limit",
        "a random view takes 1.0310 clocks per pixel, 1.0300 are the planner's bound",
        "3 pixels of the Verilog are not the golden model's"]


@pytest.mark.regress
def test_the_slowest_view_is_as_fast_as_predicted():
    found = clocks_of(replace(seen_lens((200, 136), 125, (99, 70)), nodes=8), 3)
    assert found["pixels_different"] == 0
    assert found["predicted_clocks_per_pixel"] == pytest.approx(found["clocks_per_pixel"], rel=.01)


def test_a_shaking_camera_stands_still(small):
    found = steadiness(*small, 3)
    assert found["points"] > 60
    assert found["moved_px_rms"] < .1 < 1 < found["moved_px_rms_frame"]
    assert found["moved_px_rms_hardware"] < .15
    assert 10 < found["moved_px_rms_without"] and found["off_px_max"] < .3
    assert complaints([], found) == []


@pytest.mark.parametrize("name,value", [("offset", .002), ("readout", .014)])
def test_a_clock_that_is_wrong_is_seen(small, monkeypatch, name, value):
    def wrong(*args):
        return replace(Stabiliser(*args), **{name: value})
    monkeypatch.setattr("ncdc_bench.view.steadiness.Stabiliser", wrong)
    assert "a point moves by" in complaints([], steadiness(*small, 3))[0]


def test_the_shake_is_as_strong_as_it_says():
    shake, times = Shake(3.0), np.arange(0, 60, .01)
    # Rotation vectors of such angles are twice the vector part of their quaternions.
    angles = np.degrees(2 * shake.orientation(times)[:, 1:])
    assert np.sqrt((angles**2).mean(axis=0)) == pytest.approx(3, rel=.1)
    spectrum = np.abs(np.fft.rfft(angles, axis=0))**2
    hertz = np.fft.rfftfreq(len(times), .01)
    assert spectrum[(hertz > 1.8) & (hertz < 15.2)].sum() > .98 * spectrum.sum()
    # The rates are about the camera's own axes: what they add up to is the orientation.
    step = .0005
    turned = matrices(shake.orientation(.1 + step))
    own = matrices(multiply(shake.orientation(.1), np.concatenate(
        [[1.0], shake.rates(.1 + step / 2) * step / 2])))
    assert np.abs(turned - own).max() < 1e-6


def test_the_command(small, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(command, "example_camera", small_camera)
    monkeypatch.setattr(command, "trained_lens", lambda camera: small[1])
    monkeypatch.setattr(command, "view_lens", lambda name, neurons: seen_lens())
    path, planned = tmp_path / "view.json", []
    monkeypatch.setattr(command, "clocks_of", lambda descriptor, views: planned.append(views) or {
        "clocks_per_pixel": 1.0, "predicted_clocks_per_pixel": 1.009, "pixels_different": 0,
        "bound_clocks_per_pixel": 1.03, "random_clocks_per_pixel": 1.0})
    assert main(["bench", "view", "--lens", "PC105", "--views", "2", "--frames", "2", "--json",
                 str(path)]) == 0
    assert planned == [2]
    report = json.loads(path.read_text())
    assert [row["lens"] for row in report["rows"]] == ["PC105"]
    assert report["steadiness"]["frames"] == 2
    assert main(["bench", "view", "--lens", "PC105", "--views", "2", "--frames", "2",
                 "--no-simulation"]) == 0
    assert "from frame to frame by 0.0" in capsys.readouterr().out
    assert main(["bench", "view", "--frames", "1"]) == 2
    assert "--frames is 1, 2 is the limit" in capsys.readouterr().err
