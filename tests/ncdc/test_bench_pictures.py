"""``ncdc bench pictures``: the figures of a corrected picture."""


import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_bench.pictures.measure import FLOWS, Subject, fitted, measure
from ncdc_bench.pictures.plots import busiest, plot_crops
from ncdc_bench.pictures.sets import CONDITIONS, on_grid, set_rows
from ncdc_model.images import read_image, write_image
from ncdc_spec.errors import InputError
from ncdc_spec.interpolation import DIRECTIONAL


def subject(size=(160, 120)):
    """Fine stripes, whose colours go up and down together as those of most things do."""
    v, u = np.indices(size[::-1])
    wave = np.sin(u * .9 + v * .4)
    colours = [127 + height * wave for height in (90, 80, 70)]
    return Subject("stripes", np.stack(colours, -1).astype(np.uint8))


def test_each_flow_has_its_figures_and_gradient_beats_fast():
    rows, pictures = measure(barrel_descriptor((160, 120), (160, 120)), subject())
    assert [row["flow"] for row in rows] == list(FLOWS)
    assert set(pictures) == {"reference", *FLOWS}
    by_flow = {row["flow"]: row for row in rows}
    fast, gradient = by_flow["fast"], by_flow["gradient"]
    assert gradient["psnr_db"] > fast["psnr_db"] + 3
    assert gradient["ssim"] > fast["ssim"] and gradient["false_colour"] < fast["false_colour"]
    assert all(0 < row["ssim"] < 1 for row in rows)


def test_a_set_has_a_mean_for_each_flow_and_condition(tmp_path):
    for k in range(2):
        write_image(tmp_path / f"{k}.png", np.roll(subject().colour, 7 * k, axis=1))
    rows = set_rows(tmp_path)
    flows = {"gradient", "directional", "opencv bilinear", "opencv edge-aware", "opencv vng"}
    assert len(rows) == len(CONDITIONS) * len(flows)
    assert all(row["pictures"] == 2 and row["set"] == tmp_path.name for row in rows)
    found = {(condition, row["flow"]): row["psnr_db"] for condition, row in
             zip((one for one in CONDITIONS for _ in flows), rows)}
    plain, *noisy, unbalanced, balanced = CONDITIONS
    assert found[plain, "directional"] > found[plain, "opencv vng"]
    for flow in flows:
        levels = [found[one, flow] for one in (plain, *noisy)]
        assert levels == sorted(levels, reverse=True)
        # What white balance before decoding is for: colours differ least where they are equal.
        assert abs(found[balanced, flow] - found[plain, flow]) < 3
    assert found[balanced, "directional"] > found[unbalanced, "directional"]


def test_colours_at_the_samples_are_those_of_a_corrector_that_moves_nothing():
    raw = np.random.default_rng(1).integers(0, 256, (12, 14), np.uint8)
    picture = on_grid(raw, DIRECTIONAL)
    assert picture.shape == (11, 13, 3)
    for row, column, colour in ((4, 4, 0), (4, 5, 1), (5, 5, 2)):       # RGGB
        assert picture[row, column, colour] == raw[row, column]


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
