"""``ncdc bench pictures``: the figures of a corrected picture."""

import sys

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_bench.pictures.command import table
from ncdc_bench.pictures.conditions import CONDITIONS, Condition
from ncdc_bench.pictures.measure import FLOWS, Subject, fitted, measure
from ncdc_bench.pictures.metrics import Reference, neighbours
from ncdc_bench.pictures.peers import PEERS, decoded
from ncdc_bench.pictures.plots import busiest, plot_crops
from ncdc_bench.pictures.sets import on_grid, set_rows, synthetic_rows
from ncdc_bench.pictures.synthetic import SYNTHETIC, synthetic_picture
from ncdc_model.images import mosaic, read_image, write_image
from ncdc_spec.errors import InputError
from ncdc_spec.geometry import BAYER_PHASE
from ncdc_spec.interpolation import DIRECTIONAL, GRADIENT

PACKAGED = ["malvar", "menon"]


def subject(size=(160, 120)):
    """Fine stripes, whose colours go up and down together as those of most things do."""
    v, u = np.indices(size[::-1])
    wave = np.sin(u * .9 + v * .4)
    colours = [127 + height * wave for height in (90, 80, 70)]
    return Subject("stripes", np.stack(colours, -1).astype(np.uint8))


@pytest.fixture
def without_package(monkeypatch):
    monkeypatch.setitem(sys.modules, "colour_demosaicing", None)


def test_each_flow_has_its_figures_and_gradient_beats_fast():
    rows, pictures = measure(barrel_descriptor((160, 120), (160, 120)), subject())
    assert [row["flow"] for row in rows] == list(FLOWS)
    made = [row for row in rows if row["psnr_db"] is not None]
    assert set(pictures) == {"reference", *(row["flow"] for row in made)}
    by_flow = {row["flow"]: row for row in rows}
    fast, gradient = by_flow["fast"], by_flow["gradient"]
    assert gradient["psnr_db"] > fast["psnr_db"] + 3
    assert gradient["ssim"] > fast["ssim"] and gradient["false_colour"] < fast["false_colour"]
    assert gradient["overshoot"] > fast["overshoot"]
    assert all(0 < row["ssim"] < 1 for row in made)


def test_a_package_that_is_not_installed_is_reported(without_package, tmp_path):
    rows, pictures = measure(barrel_descriptor((160, 120), (160, 120)), subject())
    absent = {row["flow"] for row in rows if row["psnr_db"] is None}
    assert absent == {f"{name}, {way}" for name in PACKAGED for way in ("bilinear", "bicubic")}
    assert set(pictures) == {"reference", *FLOWS} - absent
    write_image(tmp_path / "stripes.png", subject().colour)
    rows += set_rows(tmp_path, CONDITIONS[:1])
    assert {row["flow"] for row in rows if "set" in row and row["psnr_db"] is None} == {*PACKAGED}
    assert table(rows).count("not installed: colour-demosaicing") == 6


@pytest.mark.parametrize("bayer", BAYER_PHASE)
def test_malvar_of_others_is_our_gradient(bayer):
    """Both by integers: colours of the same kernels are rounded alike, halves too."""
    pytest.importorskip("colour_demosaicing", reason="pip install 'ncdc[test]'")
    raw = np.random.default_rng(1).integers(0, 256, (24, 30), np.uint8)
    column, row = BAYER_PHASE[bayer]
    theirs = decoded("malvar", raw, bayer)[row:, column:]
    inner = (slice(4, -4),) * 2
    np.testing.assert_array_equal(on_grid(raw[row:, column:], GRADIENT)[inner],
                                  theirs[:-1, :-1][inner])


@pytest.mark.parametrize("peer", PEERS)
def test_each_peer_knows_the_filter(peer):
    """A wrong phase would exchange colours, which are far apart here."""
    flat = np.broadcast_to(np.uint8([200, 90, 20]), (16, 16, 3))
    for bayer in BAYER_PHASE:
        colours = decoded(peer, mosaic(flat, bayer), bayer)
        if colours is None:
            pytest.skip("pip install 'ncdc[test]'")
        assert (abs(colours[4:-4, 4:-4].astype(int) - flat[0, 0]) <= 1).all()


def test_overshoot_and_false_colour_are_what_they_say():
    """A step between columns 9 and 10 of 20: these two are the tenth that is steepest."""
    levels = np.where(np.arange(20) < 10, 50, 150).astype(np.uint8)
    step = np.broadcast_to(levels[:, None], (30, 20, 3))
    reference = Reference(step, *neighbours(step), np.ones(step.shape[:2], bool))
    softer, wrong = step.copy(), step.copy()
    softer[:, 9:11] = 100                       # within its neighbours, without a colour
    figures = reference.figures(softer)
    assert figures["overshoot"] == figures["false_colour"] == figures["edge_colour"] == 0
    wrong[:, 10, 0] += 8
    figures = reference.figures(wrong)
    assert figures["overshoot"] == pytest.approx(8 / 20 / 3)
    assert figures["false_colour"] == pytest.approx(8 * (1 / 20 / 2)**.5)
    assert figures["edge_colour"] == pytest.approx(8 * (1 / 2 / 2)**.5)


@pytest.mark.parametrize("condition", CONDITIONS[4:], ids=["gains", "balanced", "linear"])
def test_what_a_sensor_sees_is_shown_right_where_it_is_flat(condition):
    colour = np.broadcast_to(np.uint8([200, 90, 30]), (8, 8, 3))
    raw = condition.raw(colour, "RGGB", np.random.default_rng(1))
    assert (condition.linear or condition.balanced_first) == (raw[0, 0] != 100)
    shown = condition.shown(decoded("opencv bilinear", raw, "RGGB"))
    assert abs(shown - condition.truth(colour)).max() <= 1
    # 8 bits of linear light are some levels apart in dark colours, once they are encoded.
    assert abs(condition.truth(colour) - colour.astype(int)).max() < 4


def test_linear_light_and_noise():
    colour = np.broadcast_to(np.uint8([255, 188, 0]), (64, 64, 3))
    raw = Condition(linear=True).raw(colour, "RGGB", np.random.default_rng(1))
    assert set(raw.ravel().tolist()) == {0, 128, 255}       # sRGB: 188 is half the light
    grey = np.full((64, 64, 3), 128, np.uint8)
    noisy = Condition(noise=5.0).raw(grey, "RGGB", np.random.default_rng(1))
    assert noisy.mean() == pytest.approx(128, abs=.3) and noisy.std() == pytest.approx(5, rel=.1)


def test_synthetic_pictures_are_the_same_everywhere_and_have_their_colours():
    for name in SYNTHETIC:
        picture = synthetic_picture(name)
        assert picture.shape == (256, 384, 3) and picture.dtype == np.uint8
        np.testing.assert_array_equal(picture, synthetic_picture(name))
        assert picture.std() > 30 and np.ptp(picture.astype(int), axis=2).max() > 50


@pytest.mark.longer
def test_the_directional_interpolation_wins_on_synthetic_pictures():
    found = {row["flow"]: row for row in synthetic_rows(CONDITIONS[:1])}
    ours = found.pop("directional")
    others = [row for row in found.values() if row["psnr_db"] is not None]
    assert ours["set"] == "synthetic" and ours["pictures"] == len(SYNTHETIC)
    assert all(ours["psnr_db"] > row["psnr_db"] + .5 for row in others)
    assert ours["overshoot"] < found["gradient"]["overshoot"] / 2


def test_a_set_has_a_mean_for_each_flow_and_condition(tmp_path):
    for k in range(2):
        write_image(tmp_path / f"{k}.png", np.roll(subject().colour, 7 * k, axis=1))
    rows = set_rows(tmp_path)
    flows = {"gradient", "directional", *PEERS}
    assert len(rows) == len(CONDITIONS) * len(flows)
    assert all(row["pictures"] == 2 and row["set"] == tmp_path.name for row in rows)
    found = {(condition, row["flow"]): row["psnr_db"] for condition, row in
             zip((one for one in CONDITIONS for _ in flows), rows)}
    plain, *noisy, unbalanced, balanced, _ = CONDITIONS
    assert found[plain, "directional"] > found[plain, "opencv vng"]
    for flow in (flow for flow in flows if found[plain, flow] is not None):
        levels = [found[one, flow] for one in (plain, *noisy)]
        assert levels == sorted(levels, reverse=True)
        # What white balance before decoding is for: colours differ least where they are equal.
        assert abs(found[balanced, flow] - found[plain, flow]) < 3
    assert found[balanced, "directional"] > found[unbalanced, "directional"]


@pytest.mark.parametrize("needs", [GRADIENT, DIRECTIONAL], ids=lambda each: each.name)
@pytest.mark.parametrize("shape", [(12, 14), (135, 131)])
def test_colours_at_the_samples_are_those_of_a_corrector_that_moves_nothing(needs, shape):
    raw = np.random.default_rng(1).integers(0, 256, shape, np.uint8)
    picture = on_grid(raw, needs)
    assert picture.shape == (shape[0] - 1, shape[1] - 1, 3)
    for row, column, colour in ((0, 0, 0), (0, 1, 1), (1, 0, 1), (1, 1, 2)):        # RGGB
        np.testing.assert_array_equal(picture[row::2, column::2, colour],
                                      raw[row:-1:2, column:-1:2])


@pytest.mark.parametrize("shape,message", [
    (None, "has no picture, a folder of"), ((20, 20), "a colour picture of at most")])
def test_what_is_no_set(tmp_path, shape, message):
    if shape:
        write_image(tmp_path / "grey.png", np.zeros(shape, np.uint8))
    with pytest.raises(InputError, match=message):
        set_rows(tmp_path)


def test_grey_has_no_false_colour_where_it_is_flat():
    flat = Subject("flat", np.full((120, 160, 3), 90, np.uint8))
    with np.errstate(divide="ignore"):
        rows, _ = measure(barrel_descriptor((160, 120), (160, 120)), flat)
    for row in rows[:2]:
        assert row["false_colour"] == 0 and row["psnr_db"] == np.inf and row["ssim"] == 1


def test_the_middle_is_taken_in_the_proportions_of_the_frame():
    wide = np.zeros((60, 200, 3), np.uint8)
    wide[:, 60:140] = 200
    assert (fitted(wide, (40, 30)) == 200).all()
    tall = np.zeros((200, 80, 3), np.uint8)
    tall[70:130] = 200
    assert (fitted(tall, (40, 30)) == 200).all()


def test_the_busiest_crop_is_where_the_detail_is():
    picture = np.zeros((120, 200, 3), np.uint8)
    picture[50:98:2, 100:164] = 255
    top, left = busiest(picture)
    assert abs(top - 50) <= 2 and abs(left - 100) <= 2


def test_the_crops_are_drawn(tmp_path):
    """The picture of another flow's crop, and of what was there before, is another picture."""
    plain = np.full((120, 160, 3), 90, np.uint8)
    shown = {"reference": plain, "fast": plain, "directional": plain}
    other = subject().colour
    drawn = []
    for k, (before, changed) in enumerate(((plain, {}), (other, {}), (plain, {"fast": other}),
                                           (plain, {"directional": other}))):
        plot_crops(tmp_path / f"{k}.jpg", before, shown | changed,
                   [{"flow": "fast", "psnr_db": 30.0}])
        drawn.append(read_image(tmp_path / f"{k}.jpg").astype(int))
    shares = [(abs(one - drawn[0]) > 60).mean() for one in drawn[1:]]
    assert all(share > .01 for share in shares) and len(set(shares)) == 3


@pytest.mark.longer
def test_a_picture_without_colour_is_rejected(tmp_path, capsys):
    assert main(["bench", "pictures", "tests/data/dots/dot_pattern_05.jpg", "--json",
                 str(tmp_path / "out.json")]) == 2
    assert "a colour picture is needed" in capsys.readouterr().err
    assert not (tmp_path / "out.json").exists()
