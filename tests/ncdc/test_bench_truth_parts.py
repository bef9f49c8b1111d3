"""Exact points, bent pages, true flaws, and what fails in the parts of ``ncdc bench truth``."""

import argparse
import json
from dataclasses import replace

import numpy as np
import pytest

from ncdc_bench.truth import aspect, bend, command, flaws, partial, render
from ncdc_bench.truth.bends import Bulge, Cylinder
from ncdc_bench.truth.lenses import LENSES, SIZE, TrueLens
from ncdc_bench.truth.synthetic import page_at, points_of, poses
from ncdc_bench.truth.true_flaws import true_flaws, true_roll
from ncdc_model.calibration.frame import ideal_frame
from ncdc_spec.errors import InputError

LENS = LENSES["equidistant 105"]
BENT = Cylinder(.01, 40), Cylinder(.003, 40, 35.0), Bulge(.3, 7.7)


def options_of(*words):
    parser = argparse.ArgumentParser()
    command.add_arguments(parser)
    return parser.parse_args(words)


@pytest.mark.parametrize("page", BENT)
def test_points_of_paper_come_back_from_a_bent_page(page):
    points = np.random.default_rng(1).uniform(-25, 25, (50, 2))
    flat, height = page.bent(points)
    back, again = page.unrolled(flat)
    np.testing.assert_allclose(back, points, atol=1e-9)
    np.testing.assert_allclose(again, height, atol=1e-9)


def test_a_cylinder_has_its_sag_and_keeps_distances_along_the_paper():
    page = Cylinder(.01, 40, 90.0)
    along = np.linspace(-20, 20, 4001)
    flat, height = page.bent(np.column_stack([np.zeros(4001), along]))
    # The sag is that of the chord: the paper is longer than it by 8 / 3 of the sag's square.
    assert np.ptp(height) == pytest.approx(.01 * 40, rel=1e-3)
    curve = np.column_stack([flat, height])
    assert np.linalg.norm(np.diff(curve, axis=0), axis=1).sum() == pytest.approx(40, rel=1e-6)
    assert not np.any(page.bent(np.array([[10.0, 0.0]]))[1])


@pytest.mark.parametrize("bent", [None, *BENT])
def test_the_renderer_has_ink_where_the_points_are(bent):
    page = page_at(LENS, 1.2, (-14, 10, -3), (48, 36), bent)
    (photo,) = points_of(LENS, [page], noise=0).photos
    angles = LENS.angles_at(photo.xy)
    ink = render._ink(np.linalg.inv(page.plane), page, angles.T)
    assert len(ink) > 500 and ink.all()
    # And none half a step away from the true centre.
    between = LENS.project(page.rays(photo.index + .5))
    assert not render._ink(np.linalg.inv(page.plane), page, LENS.angles_at(between).T).any()


def test_exact_points_are_those_of_the_rendered_page_with_the_noise_that_is_asked_for():
    page = page_at(LENS, .7, (3, -4, 5))
    truth = render._truth(LENS, page)
    exact, noisy = (points_of(LENS, [page], noise=noise).photos[0] for noise in (0, .05))
    assert len(exact.index) == 32 * 24
    np.testing.assert_array_equal(exact.xy, truth.xy)
    assert np.std(noisy.xy - exact.xy) == pytest.approx(.05, rel=.1)
    # The area of an ellipse near the axis: its half axes follow from its neighbours' distances.
    at = np.linalg.norm(exact.xy - LENS.centre, axis=1).argmin()
    step = np.median(np.linalg.norm(exact.xy - exact.xy[at], axis=1)[[at - 1, at + 1]])
    assert exact.area[at] == pytest.approx(np.pi * (render.RADIUS * step)**2, rel=.05)


@pytest.mark.parametrize("share", [.55, 1.0])
def test_a_page_fills_the_share_of_the_width(share):
    page = page_at(LENS, share, (0, 0, 0))
    ends = page.rays(page.middle + np.array([[-16.0, 0], [16, 0]]))
    assert np.ptp(LENS.project(ends)[:, 0]) / SIZE[0] == pytest.approx(share, rel=.01)


def test_corners_of_a_board_are_where_the_lens_shows_them():
    page = page_at(LENS, .9, (10, 16, 92), (9, 6))
    (photo,) = points_of(LENS, [page], "chessboard", noise=0).photos
    np.testing.assert_allclose(LENS.project(page.rays(photo.index)), photo.xy, atol=1e-9)
    assert not photo.area.any()


@pytest.mark.parametrize("lens", partial.LENSES_OF_PARTS[-3:], ids=lambda lens: lens.name)
def test_rays_of_pixels_lead_back_to_them(lens):
    xy = np.random.default_rng(2).uniform(0, np.array(SIZE) - 1, (100, 2))
    np.testing.assert_allclose(lens.of_angles(lens.angles_at(xy)), xy, atol=1e-4)


@pytest.mark.longer
def test_true_figures_of_a_lens_are_what_it_was_made_of():
    lens = replace(LENS, tilt=(np.radians(1.2), np.radians(-1.6)), aspect=1.05)
    found = true_flaws(lens)
    assert found["tilt_deg"] == pytest.approx(2.0)
    assert found["axis_px"] == pytest.approx(5.0)
    assert found["focal_px"] == pytest.approx(LENS.focal, rel=2e-3)
    assert (found["decentring_px"], found["aspect"]) == (0, 1.05)
    assert true_flaws(LENS)["focal_px"] == pytest.approx(LENS.focal, rel=1e-6)
    # A decentring of twice the size moves points twice as far.
    once, twice = (true_flaws(TrueLens("", "opencv", 760.0, k=(-.26, .08, p, 0, -.01)))
                   ["decentring_px"] for p in (.0002, .0004))
    assert twice == pytest.approx(2 * once, rel=.05) and once > .1


@pytest.mark.longer
def test_flaws_of_exact_points_are_the_true_ones():
    lens = flaws.tilted(LENS, 2.0, 0)
    pages = [page_at(lens, 1.0, turns) for turns in poses(3)]
    frame = ideal_frame(points_of(lens, pages, noise=.002))
    assert np.degrees(np.hypot(*frame.camera.tilt.angles)) == pytest.approx(2, rel=.02)
    flat = pages[0].rays(pages[0].middle + np.array([[-.5, 0], [.5, 0]]))
    turn = np.degrees(np.arctan2(*np.subtract(*(flat[:, :2] / flat[:, 2:])[::-1])[::-1]))
    assert true_roll(lens, pages[0], frame) == pytest.approx(turn, abs=.1)


def good_row():
    """A row of ``--flaws`` without a defect."""
    row = {}
    for kind, unit, value in (("focal", "_px", 700), ("axis", "_px", 5), ("decentring", "_px", 1),
                              ("tilt", "_deg", 2.0), ("aspect", "", 1), ("roll", "_deg", 4)):
        row |= {f"{kind}_true{unit}": value, f"{kind}{unit}": value, f"{kind}_error{unit}": .1}
    return row


@pytest.mark.parametrize("change, fails", [
    ({}, []), ({"focal_px": 700.31}, ["focal off"]), ({"roll_deg": 3.69}, ["roll off"]),
    ({"aspect_error": float("nan")}, ["aspect off"]), ({"tilt_deg": 2.25}, ["tilt 10 %"]),
    ({"tilt_true_deg": 1.0, "tilt_deg": 1.25}, []), ({"tilt_error_deg": .31}, ["tilt error"]),
    ({"tilt_deg": 2.5}, ["tilt off", "tilt 10 %", "good unit failed"]),
    ({"tilt_deg": 2.44}, ["tilt off", "tilt 10 %"]),
    ({"tilt_true_deg": 2.3, "tilt_deg": 2.1}, []),
    ({"tilt_true_deg": 2.5, "tilt_deg": 2.0}, ["tilt off", "tilt 10 %", "bad unit passed"])])
def test_what_fails_of_flaws(change, fails):
    assert flaws._fails(good_row() | change) == fails


@pytest.mark.parametrize("share, stated, named, fails", [
    (.55, 2.0, False, []), (.55, .9, False, ["maximum"]), (.55, .9, True, []),
    (1.0, .9, True, ["maximum"]), (1.0, 2.0, False, [])])
def test_what_fails_of_parts(share, stated, named, fails):
    row = {"page_share": share, "reported_max_px": stated, "true_max_px": 1.0,
           "beyond_named": named, "true_rms_px": .1, "reported_rms_px": .09}
    assert partial._fails(row) == fails
    row["reported_rms_px"] = .07
    assert partial._fails(row) == fails + ["rms"] * (share == 1)


@pytest.mark.parametrize("page, photos, change, fails", [
    ("flat", 3, {}, []), ("flat", 1, {"named": True}, ["flat page"]),
    ("flat", 3, {"sag_percent": .1, "sag_true_percent": .1}, ["flat page"]),
    ("bulge", 3, {"true_rms_px": .16}, ["silent"]), ("bulge", 3, {"true_rms_px": .14}, []),
    ("bulge", 1, {"true_max_px": .16}, []),
    ("cylinder 1 %", 1, {"true_max_px": .16}, ["sag's effect"]),
    ("cylinder 1 %", 1, {"true_max_px": .14}, []),
    ("bulge", 3, {"true_rms_px": 2, "named": True}, []),
    ("bulge", 3, {"sag_percent": .2, "sag_true_percent": .3}, ["sag"]),
    ("bulge", 3, {"sag_percent": .28, "sag_true_percent": .3}, [])])
def test_what_fails_of_bends(page, photos, change, fails):
    row = {"page": page, "photos": photos, "named": False, "sag_percent": 0.0, "relief_px": 0.0,
           "sag_true_percent": 0.0, "sag_error_percent": .01, "true_rms_px": .01,
           "true_max_px": .1, "bent_max_px": .15}
    assert bend._fails(row | change) == fails


def test_a_focal_length_that_is_not_determined_does_not_fail(monkeypatch):
    def figures(value, error):
        return lambda *_: {"focal_px": value, "focal_error_px": error, "focal_true_px": 700.0}
    monkeypatch.setattr(aspect, "ideal_frame", lambda points: None)
    for value, error, determined, fails in ((600, 100, False, 0), (600, 1, True, 1),
                                            (703, 1, True, 0)):
        monkeypatch.setattr(aspect, "compared", figures(value, error))
        row = aspect.row_of(1.0, 3, True)
        assert (row["determined"], len(row["fails"])) == (determined, fails)


@pytest.mark.longer
def test_a_part_reports_rows_and_its_summary(capsys):
    code = command.run(options_of("--flaws", "--exact-points", "--only",
                                  "equidistant 105, 2 deg, chessboard", "--json", "-"))
    report = json.loads(capsys.readouterr().out)
    (row,) = report["rows"]
    assert code == 0 and row["fails"] == [] and row["target"] == "chessboard"
    assert row["tilt_true_deg"] == pytest.approx(2) and 0 < row["tilt_error_deg"] < .3
    assert (row["photos"], row["page_share"]) == (3, 1.0)
    assert report["summary"]["chessboard"]["rows"] == 1 and "| 2.0" in flaws.table([row])


@pytest.mark.parametrize("words, text", [
    (("--flaws", "--target", "charuco"), "--target charuco is of the bench without"),
    (("--partial", "--dots"), "--dots is of rendered photos"),
    (("--exact-points", "--target", "charuco"), "--exact-points has dots and chessboard"),
    (("--aspect", "--photos", "2"), "--aspect measures one photo"),
    (("--photos", "4"), "--photos is 4, of dots there are at most 3"),
    (("--only", "no lens"), "no lens has such a name"),
    (("--bend", "--only", "("), "no regular expression")])
def test_what_a_part_cannot_do_is_rejected(words, text):
    with pytest.raises(InputError, match=text.replace("(", r"\(")):
        command.run(options_of(*words))
