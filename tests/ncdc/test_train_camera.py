"""A camera file from train to evaluate: its own frame, its scale, and what is said of them."""

import json

import pytest

from ncdc.cli import main

INFO = {"width": 160, "height": 120, "distortion_model": "plumb_bob", "D": [-.2, .05, 0, 0, 0],
        "K": [100.0, 0, 81.5, 0, 101.0, 58.25, 0, 0, 1],
        "R": [1.0, 0, 0, 0, 1, 0, 0, 0, 1], "P": [90.0, 0, 80, 0, 0, 80.0, 60, 0, 0, 0, 1, 0]}
SPARE = "--neurons", "1", "--trainer", "ebp", "--epochs", "20"


@pytest.fixture
def info(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "info.yaml").write_text(json.dumps(INFO))


@pytest.mark.longer
def test_the_frame_of_the_file_is_the_one_that_evaluate_measures(info, capsys):
    assert main(["train", "info.yaml", *SPARE, "-o", "net.toml", "--json", "train.json"]) == 0
    assert ("the corrected picture is that of the projection matrix: focal lengths 90.00 and 80.00,"
            " centre (80.00, 60.00); --zoom gives another\n") in capsys.readouterr().err
    assert main(["evaluate", "net.toml", "--reference", "info.yaml", "--json", "-"]) == 0
    measured = json.loads(capsys.readouterr().out)
    trained = json.load(open("train.json"))
    assert measured["measured_on"] == "frame, view trained"
    assert measured["map_error_fixed_px"] == pytest.approx(trained["map_error_fixed_px"])
    assert any("projection matrix" in note for note in trained["notes"])


@pytest.mark.longer
def test_a_scaled_calibration_is_scaled_by_evaluate_too(info, capsys):
    assert main(["train", "info.yaml", *SPARE, "--sensor-size", "80x60", "-o", "net.toml", "--json",
                 "train.json"]) == 0
    said = ("the calibration is for 160x120 pixels, the sensor has 80x60: focal lengths and centre "
            "are scaled by 0.5\n")
    assert said in capsys.readouterr().err
    assert main(["evaluate", "net.toml", "--reference", "info.yaml", "--json", "got.json"]) == 0
    assert said in capsys.readouterr().err
    assert json.load(open("got.json"))["map_error_fixed_px"] == pytest.approx(
        json.load(open("train.json"))["map_error_fixed_px"])
    assert main(["train", "info.yaml", *SPARE, "--sensor-size", "80x80", "-o", "n.toml"]) == 2
    assert "of another aspect: a frame that is cut" in capsys.readouterr().err
