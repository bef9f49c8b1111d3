"""Cameras of exactly known rays: the renderer itself, and what calibration makes of it."""

import argparse
import json
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from ncdc_bench.truth import command, measure
from ncdc_bench.truth.lenses import LENSES, SIZE
from ncdc_bench.truth.measure import detect, page_of
from ncdc_bench.truth.render import photograph
from ncdc_model.calibration.frame import ideal_frame
from ncdc_model.calibration.quality import uneven
from ncdc_model.lens import rotation
from ncdc_spec.errors import InputError


@cache
def detected(name):
    """What is found on one photo by a lens, and how much of what it shows."""
    return detect(LENSES[name], 1)


def report_of(capsys, *words):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    code = command.run(parser.parse_args([*words, "--json", "-"]))
    return code, json.loads(capsys.readouterr().out)["rows"]


@pytest.mark.parametrize("name", LENSES)
def test_rays_of_pixels_lead_back_to_them(name):
    lens, rng = LENSES[name], np.random.default_rng(2)
    xy = rng.uniform(0, np.array(SIZE) - 1, (200, 2))
    np.testing.assert_allclose(lens.of_angles(lens.angles_at(xy)), xy, atol=1e-4)


@pytest.mark.longer
def test_the_photo_shows_the_dots_where_the_truth_says():
    lens = LENSES["equidistant 126"]
    shot = photograph(lens, page_of(lens, 0))
    (truth,) = shot.truths
    at = np.rint(truth.xy[truth.visible]).astype(int)
    assert truth.visible.sum() > 400
    assert (shot.image[at[:, 1], at[:, 0]] < 90).mean() > 0.99
    assert np.median(shot.image) > 150


@pytest.mark.longer
@pytest.mark.parametrize("name", [name for name in LENSES if "equidistant" in name])
def test_nearly_all_dots_of_a_clean_page_are_used(name):
    _, (dots,) = detected(name)
    assert dots.used >= 0.97 * dots.visible and not dots.false


@pytest.mark.longer
@pytest.mark.parametrize("name", LENSES)
def test_a_flat_page_has_no_relief_and_only_bumps_are_warned_of(name):
    points, _ = detected(name)
    frame = ideal_frame(points)
    assert not frame.relief.any()
    assert len(uneven(points, frame)) == (name == "bumps")


@pytest.mark.longer
@pytest.mark.parametrize("name", ["pixels 1:1.06", "bumps"])
def test_the_report_says_no_less_than_there_is(capsys, name):
    code, (row,) = report_of(capsys, "--only", name, "--photos", "1", "--neurons", "6")
    assert code == 0 and row["relief_px"] == 0
    assert row["reported_max_px"] >= row["true_max_px"] > row["true_rms_px"] > 0.02
    assert row["reported_rms_px"] == pytest.approx(row["true_rms_px"], rel=0.25)
    assert (row["target"], row["photos"], row["page_share"], row["tilt_true_deg"]) == (
        "dots", 1, 1.0, 0.0)
    assert row["tilt_deg"] <= 3 * row["tilt_error_deg"]
    assert row["warned"] == bool(row["warnings"]) == (name == "bumps")


def test_a_map_that_is_off_by_a_known_bump_is_measured_as_that(monkeypatch):
    lens = LENSES["equidistant 105"]
    valid = np.zeros(SIZE[::-1], bool)
    valid[200:700, 300:1000] = True
    descriptor = SimpleNamespace(geometry=SimpleNamespace(corrected=SIZE),
                                 valid=SimpleNamespace(mask=lambda width: valid))

    def view(u, v):
        """A pinhole picture, turned and in perspective."""
        rays = np.stack([u - 600.0, v - 450.0, np.full(len(u), 500.0)], axis=1)
        return rays @ rotation(0.1, -0.05, 0.2).T

    def bumpy(descriptor):
        def back_map(u, v):
            x, y = lens.project(view(u, v)).T
            return x + 2 * np.exp(-((u - 650)**2 + (v - 450)**2) / 200), y
        return back_map
    monkeypatch.setattr(measure, "fixed_map", bumpy)
    rms, worst = measure.true_errors(lens, descriptor)
    # The square of exp(-d^2 / 200) covers 100 pi pixels; a homography takes up a little of it.
    assert rms == pytest.approx(2 * np.sqrt(100 * np.pi / valid.sum()), rel=0.06)
    assert worst == pytest.approx(2, rel=0.06)


@pytest.mark.longer
@pytest.mark.parametrize("target", ["chessboard", "charuco", "aprilgrid"])
def test_corners_of_boards_are_where_the_truth_says(capsys, target):
    code, (row,) = report_of(capsys, "--target", target, "--only", "equidistant 150", "--photos",
                             "1", "--dots")
    assert code == 0 and row["target"] == target and row["photos"] == 1
    assert row["corners_misnumbered"] == 0
    assert row["corners_used"] >= 0.95 * row["corners_visible"] > 150
    assert row["corner_rms_px"] < 0.08 and row["corner_max_px"] < 0.4


def test_there_are_so_many_photos_of_a_target(capsys):
    with pytest.raises(InputError, match="--photos is 4, of dots there are at most 3"):
        report_of(capsys, "--photos", "4")
