"""The line test: straight, bent and turned boards of known positions; ``ncdc bench lines``."""

import json

import cv2
import numpy as np
import pytest

from ncdc.cli import main
from ncdc_bench.lines.measure import (
    DARK,
    LIGHT,
    board_photo,
    board_pitch,
    corrected,
    crossings,
    find_lines,
    summary,
)
from ncdc_bench.reference_lenses import ReferenceLens

PITCH, SIZE = 40.0, (640, 480)


def board(bend, blank=None):
    """Lines found on a chessboard drawn without a lens, pixel (u, v) showing ``bend(u, v)``."""
    u, v = np.meshgrid(np.arange(0, SIZE[0], .25), np.arange(0, SIZE[1], .25))
    sign = 1.0
    for position in bend(u - .375, v - .375):
        distance = PITCH * (np.abs(np.mod(position / PITCH, 2) - 1) - .5)
        sign = sign * np.clip(distance / .5, -1, 1)
    grey = cv2.resize(DARK + (LIGHT - DARK) * (1 + sign) / 2, SIZE, interpolation=cv2.INTER_AREA)
    noise = np.random.default_rng(5).normal(0, 1.5, grey.shape)
    picture = np.repeat(np.clip(grey + noise, 0, 255).astype(np.uint8)[:, :, None], 3, axis=2)
    known = np.ones(picture.shape[:2], bool)
    if blank:
        known[blank], picture[blank] = False, 0
    grid = np.meshgrid(np.arange(PITCH / 2, SIZE[0], PITCH), np.arange(PITCH / 2, SIZE[1], PITCH))
    # The bends are small: one step of the inverse.
    there = bend(*grid)
    return find_lines(picture, known, PITCH, (2 * grid[0] - there[0], 2 * grid[1] - there[1]))


def wave(height):
    return lambda u, v: (u + height * np.sin(v / 60), v)


def test_straight_board():
    lines = board(lambda u, v: (u, v))
    report = summary(lines)
    assert report["lines"] == 16 + 12 == len(lines) and report["lines_missed"] == 0
    assert report["straightness_rms_px"] < .05 and report["straightness_max_px"] < .3
    upright = [line for line in lines if line.upright]
    assert len(upright) == 16
    for k, line in enumerate(upright):
        np.testing.assert_allclose(line.ends[:, 0], PITCH * (k + .5), atol=.1)
        assert line.ends[0, 1] < 5 and line.ends[1, 1] > 474


def test_turned_board_is_straight():
    report = summary(board(lambda u, v: (u + .02 * (v - 240), v - .02 * (u - 320))))
    assert report["lines_missed"] == 0 and report["straightness_rms_px"] < .06


@pytest.mark.parametrize("height", [.4, 1.0, 4.0])
def test_bend_is_measured(height):
    lines = board(wave(height))
    upright = [line for line in lines if line.upright]
    # What the best straight line leaves of the wave over the frame's height.
    v = np.arange(5, 475.0)
    left = height * np.sin(v / 60)
    left -= np.polyval(np.polyfit(v, left, 1), v)
    report = summary(upright)
    assert report["straightness_rms_px"] == pytest.approx(left.std(), rel=.07, abs=.01)
    assert report["straightness_max_px"] == pytest.approx(np.abs(left).max(), abs=.3)
    assert report["lines_missed"] == (16 if height == 4 else 0)
    assert summary([line for line in lines if not line.upright])["lines_missed"] == 0


def test_pixels_without_a_source_are_left_out():
    blank = np.s_[:300, 200:440]
    lines = board(lambda u, v: (u, v), blank)
    report = summary(lines)
    assert report["lines_missed"] == 0 and report["straightness_rms_px"] < .05
    short = [line for line in lines if line.upright and 200 < line.ends[0, 0] < 440]
    assert short and all(line.ends[0, 1] > 300 for line in short)
    assert summary(board(lambda u, v: (u, v), np.s_[:, 200:440]))["lines"] == 10 + 12


@pytest.fixture(scope="module")
def photo():
    lens = ReferenceLens("PC105")
    return lens, board_photo(lens)


@pytest.mark.longer
def test_true_map_leaves_straight_lines(photo):
    lens, raw = photo
    back_map = lens.camera.back_map
    crossing = crossings(lens, back_map)
    np.testing.assert_allclose(crossing[0][0], np.arange(32, 1280, 64), atol=1e-6)
    picture, known = corrected(back_map, raw, lens.geometry)
    assert known.mean() == pytest.approx(.961, abs=.003)
    report = summary(find_lines(picture, known, board_pitch(lens.geometry), crossing))
    assert report["lines"] == 36 and report["lines_missed"] == 0
    assert report["straightness_rms_px"] < .05


def test_crossings_follow_the_map(photo):
    lens, _ = photo
    u, v = crossings(lens, lambda u, v: lens.camera.back_map(u - 3.0, v + .01 * (u - 600)))
    true_u, true_v = np.meshgrid(np.arange(32, 1280, 64.0), np.arange(32, 1024, 64.0))
    np.testing.assert_allclose(u, true_u + 3, atol=1e-5)
    np.testing.assert_allclose(v, true_v - .01 * (true_u - 597), atol=1e-5)


@pytest.mark.longer
def test_command(tmp_path, monkeypatch, photo):
    monkeypatch.setattr("ncdc_bench.lines.command.board_photo", lambda lens: photo[1])
    assert main(["bench", "lines", "--lens", "PC105", "--model", "pbm6-separate", "-o",
                 str(tmp_path), "--json", str(tmp_path / "report.json")]) == 0
    truth, pbm = json.loads((tmp_path / "report.json").read_text())["rows"]
    assert (truth["model"], pbm["model"], pbm["lens"]) == ("true", "pbm6-separate", "PC105")
    assert truth["lines_missed"] == 0 and truth["straightness_rms_px"] < .05
    assert .1 < pbm["straightness_rms_px"] < 1 and pbm["mse"] == pytest.approx(.158, rel=.03)
    picture = cv2.imread(str(tmp_path / "lines-PC105.jpg"))
    assert picture.shape[1] > 800 and (tmp_path / "lines-PC105.jpg").stat().st_size < 300000


def test_output_that_cannot_be_written(capsys):
    assert main(["bench", "lines", "-o", "/dev/null/plots"]) == 2
    assert "cannot write /dev/null/plots/lines.jpg" in capsys.readouterr().err


@pytest.mark.regress
def test_network_keeps_lines_that_the_polynomial_bends(tmp_path):
    assert main(["bench", "lines", "--lens", "105br", "--model", "pbm6-shared", "ncdc",
                 "--neurons", "12", "--json", str(tmp_path / "report.json")]) == 0
    _, pbm, network = json.loads((tmp_path / "report.json").read_text())["rows"]
    assert pbm["lines_missed"] >= 4 and network["lines_missed"] == 0
    assert network["straightness_rms_px"] < .07
