"""White balance and tone on the command line: correct, simulate, generate."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc_model.golden.colour import ColourSums, coloured, gains_of
from ncdc_model.golden.corrector import correct
from ncdc_model.golden.tone import tone_named
from ncdc_model.images import read_image, write_image
from ncdc_spec.colour import Colour
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.interpolation import CRESTS, DIRECTIONAL
from ncdc_spec.raw_gains import NO_RAW_GAINS
from ncdc_spec.white_balance import UNITY, grey_world

D = barrel_descriptor((40, 24), (50, 34), hidden_neurons=2, fill=(250, 20, 3))


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Folder with a descriptor and a raw frame whose green is the brightest."""
    path = tmp_path_factory.mktemp("colour")
    D.save(path / "net.toml")
    raw = np.random.default_rng(1).integers(0, 90, (34, 50))
    raw[::2, 1::2] *= 2
    raw[1::2, ::2] *= 2
    write_image(path / "raw.png", raw.astype(np.uint8))
    return path


def run(folder, command, output, *options):
    return main([command, str(folder / "net.toml"), str(folder / "raw.png"), "-o", str(output),
                 *options])


def plain(folder, raw_gains=NO_RAW_GAINS):
    return correct(D, read_image(folder / "raw.png"), raw_gains=raw_gains)


@pytest.mark.parametrize("options,expected", [
    ([], lambda f: Colour()), (["--tone", "linear"], lambda f: Colour()),
    (["--white-balance", "1.8,1,1.4"], lambda f: Colour(gains_of("1.8,1,1.4"))),
    (["--tone", "sRGB"], lambda f: Colour(tone=tone_named("sRGB"))),
    (["--white-balance", "grey-world", "--tone", "gamma:2.2"], lambda f: Colour(
        grey_world(ColourSums.of(f).colours), tone_named("gamma:2.2")))])
def test_correct_follows_the_options(folder, tmp_path, options, expected):
    assert run(folder, "correct", tmp_path / "out.png", *options) == 0
    frame = plain(folder)
    np.testing.assert_array_equal(read_image(tmp_path / "out.png"),
                                  coloured(frame, expected(frame)))


@pytest.mark.parametrize("text", ["1.8,1,1.4", "grey-world"])
@pytest.mark.parametrize("after", [[], ["--white-balance", "grey-world", "--tone", "sRGB"]])
def test_raw_frames_are_balanced_before_interpolation(folder, tmp_path, text, after):
    raw_gains = (grey_world(ColourSums.of(plain(folder)).colours) if text == "grey-world"
                 else gains_of(text))
    frame = plain(folder, raw_gains)
    colour = Colour(raw_gains=raw_gains)
    if after:
        colour = Colour(grey_world(ColourSums.of(frame).colours), tone_named("sRGB"))
    assert run(folder, "correct", tmp_path / "out.png", "--raw-balance", text, *after, "--json",
               str(tmp_path / "out.json")) == 0
    np.testing.assert_array_equal(read_image(tmp_path / "out.png"), coloured(frame, colour))
    report = json.loads((tmp_path / "out.json").read_text())
    assert report["raw_gains"] == [gain / UNITY for gain in raw_gains]
    assert raw_gains != NO_RAW_GAINS and not np.array_equal(frame.picture, plain(folder).picture)


@pytest.mark.longer
def test_the_verilog_balances_raw_frames(folder, tmp_path, capsys):
    for command in ("correct", "simulate"):
        assert run(folder, command, tmp_path / f"{command}.png", "--raw-balance", "grey-world",
                   "--json", str(tmp_path / f"{command}.json")) == 0
    np.testing.assert_array_equal(read_image(tmp_path / "simulate.png"),
                                  read_image(tmp_path / "correct.png"))
    report = json.loads((tmp_path / "simulate.json").read_text())
    assert report["raw_balance"] and not report["colour"] and report["pixels_different"] == 0
    assert capsys.readouterr().out.count("raw gains ") == 2


@pytest.mark.longer
def test_the_verilog_gives_the_picture_of_the_golden_model(folder, tmp_path, capsys):
    options = ["--white-balance", "grey-world", "--tone", "sRGB"]
    for command in ("correct", "simulate"):
        assert run(folder, command, tmp_path / f"{command}.png", *options, "--json",
                   str(tmp_path / f"{command}.json")) == 0
    np.testing.assert_array_equal(read_image(tmp_path / "simulate.png"),
                                  read_image(tmp_path / "correct.png"))
    one, two = (json.loads((tmp_path / f"{command}.json").read_text())
                for command in ("correct", "simulate"))
    assert one["gains"] == two["gains"] and one["tone_nodes"] == two["tone_nodes"]
    assert two["colour"] and two["pixels_different"] == 0
    sums = ColourSums.of(plain(folder))
    assert {name: two[name.lower()] for name in sums.registers} == sums.registers
    gains = ", ".join(f"{gain:.3f}" for gain in one["gains"])
    assert capsys.readouterr().out.count(f"gains {gains}; tone sRGB; crest off\n") == 2


def test_crests_are_those_of_the_directional_interpolation(folder, tmp_path, capsys):
    picture = tmp_path / "out.png"
    assert run(folder, "correct", picture, "--crest", "mild") == 2
    assert "the interpolation is fast, a crest needs directional" in capsys.readouterr().err
    assert not picture.exists()
    descriptor = Descriptor.load(folder / "net.toml")
    directional = replace(descriptor, geometry=replace(descriptor.geometry,
                                                       interpolation=DIRECTIONAL))
    directional.save(tmp_path / "net.toml")
    raw = read_image(folder / "raw.png")
    shutil.copy(folder / "raw.png", tmp_path)
    for name, strength in CRESTS.items():
        assert run(tmp_path, "correct", picture, "--crest", name) == 0
        np.testing.assert_array_equal(read_image(picture),
                                      correct(directional, raw, crest=strength).picture)


def test_a_gain_at_its_limit_is_reported(folder, tmp_path, capsys):
    """A frame without blue: no gain makes it grey."""
    raw = read_image(folder / "raw.png").copy()
    raw[1::2, 1::2] = 0
    write_image(tmp_path / "raw.png", raw)
    assert main(["correct", str(folder / "net.toml"), str(tmp_path / "raw.png"), "-o",
                 str(tmp_path / "out.png"), "--white-balance", "grey-world"]) == 0
    assert "; blue would need more than 3.996, the largest gain\n" in capsys.readouterr().out


@pytest.mark.parametrize("command", ["correct", "simulate"])
@pytest.mark.parametrize("options,sentence", [
    (["--white-balance", "0,1,1"],
     "the gain of red is 0, the limits are 0.00390625 and 3.99609375"),
    (["--white-balance", "1,1,1,1,1"],
     "the white balance is '1,1,1,1,1', three gains R,G,B or grey-world is needed"),
    (["--white-balance", ""], "the white balance is '', three gains R,G,B or grey-world is needed"),
    (["--raw-balance", "1,4,1"],
     "the gain of green is 4, the limits are 0.00390625 and 3.99609375"),
    (["--raw-balance", "grey"],
     "the raw balance is 'grey', three gains R,G,B or grey-world is needed"),
    (["--tone", "gamma:9"], "the gamma of the tone is 9, the limits are 1 and 3"),
    (["--tone", "film"], "the tone is 'film', one of linear, sRGB, gamma:G is needed")])
def test_careless_options_are_rejected(folder, tmp_path, command, options, sentence, capsys):
    output = tmp_path / "out.png"
    output.write_text("earlier")
    assert run(folder, command, output, *options) == 2
    assert capsys.readouterr().err == f"ncdc {command}: {sentence}\n"
    assert output.read_text() == "earlier"


def test_raw_frames_of_the_multiport_fetcher_are_not_balanced(folder, tmp_path, capsys):
    assert run(folder, "simulate", tmp_path / "out.png", "--fetch", "multiport", "--raw-balance",
               "2,1,1") == 2
    assert capsys.readouterr().err == ("ncdc simulate: fetch is multiport, gains of raw samples "
                                       "need cache\n")


@pytest.mark.longer
def test_generate_puts_it_in_only_if_asked(folder, tmp_path):
    texts = {}
    for name, options in (("without", []), ("with", ["--colour", "--raw-gains"])):
        assert main(["generate", str(folder / "net.toml"), "-o", str(tmp_path / name),
                     *options]) == 0
        texts[name] = {file: (tmp_path / name / file).read_text()
                       for file in ("ncdc.v", "ncdc_registers.h", "ncdc_registers.py",
                                    "ncdc_lenses.c")}
    assert texts["without"] != texts["with"]
    assert texts["without"]["ncdc_lenses.c"] == texts["with"]["ncdc_lenses.c"]
    for word, file in (("--colour", "ncdc.v"), ("--raw-gains", "ncdc.v"),
                       ("RAW_GAIN_BLUE", "ncdc_registers.h"),
                       ("reg [9:0] raw_gain_red = 10'h100;", "ncdc.v"),
                       ("reg [9:0] gain_red = 10'h100;", "ncdc.v"),
                       ("NCDC_TONE_SRGB", "ncdc_registers.h"), ("TONES", "ncdc_registers.py")):
        assert word in texts["with"][file] and word not in texts["without"][file], word
