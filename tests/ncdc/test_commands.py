"""The command line: good runs on small input, and one sentence on bad input."""

import json
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest

from cameras import barrel_descriptor
from cases import cases
from ncdc import cli
from ncdc_hdl.export.verilog import corrector_verilog
from ncdc_model.golden.corrector import correct
from ncdc_model.images import mosaic, read_image, write_image
from ncdc_spec.cache_options import CacheOptions
from ncdc_spec.descriptor import Descriptor
from ncdc_spec.hardware import Hardware


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with a descriptor, a fitting raw frame, a colour picture, and nothing else."""
    rng = np.random.default_rng(1)
    barrel_descriptor(fill=(1, 2, 3)).save(tmp_path / "net.toml")
    write_image(tmp_path / "raw.png", rng.integers(0, 256, (40, 48), np.uint8))
    write_image(tmp_path / "colour.png", rng.integers(0, 256, (40, 48, 3), np.uint8))
    write_image(tmp_path / "small.png", np.zeros((40, 47), np.uint8))
    write_image(tmp_path / "blank.png", np.full((200, 300), 200, np.uint8))
    (tmp_path / "text.png").write_text("no picture")
    monkeypatch.chdir(tmp_path)
    return tmp_path


def contents(folder):
    return {path.relative_to(folder): path.read_bytes()
            for path in folder.rglob("*") if path.is_file()}


def run(command):
    """Exit status of ``ncdc command``, however it ends."""
    try:
        return cli.main(command.split())
    except SystemExit as end:
        return end.code


def damage(folder, pattern, replacement):
    text = (folder / "net.toml").read_text()
    changed = re.sub(pattern, replacement, text, count=1, flags=re.DOTALL)
    assert changed != text
    (folder / "net.toml").write_text(changed)


def check_rejected(folder, command, message, capsys):
    before = contents(folder)
    assert run(command) == 2
    out, err = capsys.readouterr()
    assert re.search(message, err), err
    # Progress is shown up to the photo that is rejected.
    said = re.sub(r"^\w+: +\d+ %.*\n", "", err, flags=re.MULTILINE)
    assert said.count("\n") == 1 and "Traceback" not in err and not out, err
    assert contents(folder) == before


USES = {
    "correct": "correct {net} {image} -o {out}",
    "simulate": "simulate {net} {image} -o {out}",
    "generate": "generate {net} -o {out}",
}


def use(command, net="net.toml", image="raw.png", out="out.png"):
    return USES[command].format(net=net, image=image, out=out)


@pytest.mark.parametrize("command", USES)
@pytest.mark.parametrize("pattern,replacement,message", [
    (r"hidden_weights = \[\n    \[-?\d+", "hidden_weights = [\n    [8388608",
     r"hidden_weights holds 8388608 \(8\), the limits of Q4\.20 are -8388608 and 8388607"),
    (r"output_biases = \[-?\d+", "output_biases = [-99999999999",
     r"output_biases holds -99999999999"),
    (r"rows = \[.*", "rows = [", r"net\.toml is no descriptor"),
    (r"\[valid\].*", "", r"net\.toml lacks the value 'valid'"),
    (r"\n    \[[\d, ]+\],\n\]\n$", "\n]\n", r"the valid spans cover 39 rows, the image has 40"),
    (r"version = 1", "version = 9", r"descriptor version 9, version 1 is needed"),
    (r"corrected_width = 48", "corrected_width = 9999",
     r"corrected_width is 9999, the limits are 8 and 4096"),
    (r"hidden_biases = \[-?\d+", "hidden_biases = [1.5",
     r"hidden_biases holds values that are no integers"),
    (r"coordinate = \[14, 10\]", "coordinate = [5, 10]",
     r"coordinates Q5\.10 end at 15\.999, the distorted image has 48 pixels on a side"),
    (r"net = \[5, 19\]", "net = [5, 17]",
     r"the format net is Q5\.17, the tan-sigmoids are proven for Q5\.19"),
    (r"input = \[1, 23\]", "input = [0, 23]", r"the format input Q0\.23 does not suit the scan"),
    (r"input = \[1, 23\]", "input = [-3, 23]", r"the format input Q-3\.23 does not suit the scan"),
    (r"input = \[1, 23\]", "input = [1, 31]", r"the format input Q1\.31 does not suit the scan"),
    (r"input = \[1, 23\]", "input = [1.0, 23.0]", r"Q1\.0\.23\.0 is no format"),
    (r"coordinate = \[14, 10\]", "coordinate = [14, 0]",
     r"coordinates Q14\.0 have no fraction bit"),
    (r"input = \[1, 23\]\nhidden_weight = \[4, 20\]", "input = [1, 30]\nhidden_weight = [1, 31]",
     r"sums of 2 products Q1\.30 x Q1\.31 and the bias Q5\.27 need 6\d bits, the limit is 63"),
    (r"fill = \[1, 2, 3\]", "fill = [0.5, 0, 0]",
     r"fill is \[0\.5, 0, 0\], three values of 0\.\.255"),
    (r"fill = \[1, 2, 3\]", "fill = [true, 0, 0]",
     r"fill is \[True, 0, 0\], three values of 0\.\.255"),
    (r"rows = \[\n    \[\d+, \d+,", "rows = [\n    [9, 3,",
     r"row 0 leaves the limits 0 and 48 or ends before"),
    (r"net = \[5, 19\]", "net = [5, 44]", r"the format net Q5\.44 has 49 bits, the limit is 32"),
    (r"output_weight = \[12, 12\]", "output_weight = [34, -12]", r"too few for the bias Q14\.18"),
    (r"(in pixels\nhidden_weights = \[\n    \[)[^,]+", r"\1nan",
     r"hidden_weights before quantisation holds a value that is not finite"),
    (r"\"RGGB\"", "\"RGBG\"", r"bayer is 'RGBG', one of RGGB, GRBG, GBRG, BGGR, MONO is needed"),
])
def test_bad_descriptor(folder, command, pattern, replacement, message, capsys):
    damage(folder, pattern, replacement)
    check_rejected(folder, use(command), message, capsys)


@pytest.mark.parametrize("command", USES)
def test_missing_descriptor(folder, command, capsys):
    check_rejected(folder, use(command, net="none.toml"),
                  f"ncdc {command}: cannot read none.toml: No such file", capsys)


@pytest.mark.parametrize("command", ["correct", "simulate"])
@pytest.mark.parametrize("image,message", [
    ("none.png", "cannot read none.png: No such file"),
    ("text.png", "text.png holds no image"),
    ("small.png", "the picture has 47x40 pixels, the descriptor is for 48x40"),
])
def test_bad_image(folder, command, image, message, capsys):
    check_rejected(folder, use(command, image=image), message, capsys)


@pytest.mark.parametrize("image,message", [
    ("none.png", "cannot read none.png: No such file"), ("text.png", "text.png holds no image"),
    ("blank.png", "blank.png")])
@pytest.mark.parametrize("target", ["dots", "chessboard:9x6", "circles:5x4", "auto"])
def test_calibrate_without_a_target(folder, image, message, target, capsys):
    check_rejected(folder, f"calibrate {image} --target {target} -o points.json", message, capsys)


@pytest.mark.parametrize("command", [
    "calibrate raw.png --target hexagons:3x3 -o p.json",
    "calibrate raw.png --target chessboard -o p.json",
    "train none.json --neurons 4", "train net.toml --neurons 4", "train raw.png --neurons 4",
    "evaluate net.toml --reference none.json", "evaluate none.toml --reference raw.png",
    "correct net.toml raw.png", "correct net.toml raw.png -o out.nonsense",
    "generate net.toml -o out --data-width 48", "generate net.toml -o out --fetch magic",
    "simulate net.toml raw.png -o out.png --memory tape",
    "simulate net.toml raw.png -o o.png --simulator x",
    "demo --neurons 0 -o out", "demo --neurons 99 -o out", "nonsense", ""])
def test_bad_usage(folder, command, capsys):
    check_rejected(folder, command, "ncdc", capsys)


@pytest.mark.parametrize("command", cases([*USES], longer=["generate"]))
def test_unwritable_output(folder, command, capsys):
    # Not even root can make files below /proc.
    check_rejected(folder, use(command, out="/proc/none/out.png"), "cannot write /proc/none",
                   capsys)


@pytest.mark.parametrize("command,message", [
    ("correct net.toml raw.png -o raw.png", "the output raw.png would replace the input raw.png"),
    ("correct net.toml raw.png -o o.png --json o.png", "would replace the output o.png"),
    ("correct net.toml raw.png -o o.png --json net.toml", "would replace the input net.toml"),
    ("correct net.toml raw.png -o o.png --json .", "cannot write .: it is a folder"),
    ("correct net.toml raw.png -o net.toml/o.png", "cannot write net.toml/o.png"),
    ("simulate net.toml raw.png -o o.png --seed -1", "seed is -1, it must not be negative"),
    ("train net.toml --neurons 4 -o /proc/none/n.toml", "cannot write /proc/none/n.toml"),
    ("calibrate raw.png -o /proc/none/p.json", "cannot write /proc/none/p.json"),
    ("evaluate net.toml --reference raw.png --json /proc/none/e.json", "cannot write /proc/none"),
    ("demo -o /proc/none", "cannot write /proc/none")])
def test_outputs_are_checked_before_any_work(folder, command, message, capsys):
    check_rejected(folder, command, message, capsys)


@pytest.mark.parametrize("target", ["dots", "chessboard:9x6", "circles:5x4", "auto"])
def test_a_tiny_photo(folder, target, capsys):
    write_image(folder / "tiny.png", np.zeros((1, 1), np.uint8))
    check_rejected(folder, f"calibrate tiny.png --target {target} -o p.json",
                  "it is 1x1, 8 pixels on a side are the limit", capsys)


def test_a_failed_run_leaves_the_old_output(folder, capsys):
    assert run(use("correct")) == 0
    capsys.readouterr()
    check_rejected(folder, use("correct", image="small.png"), "47x40", capsys)


def test_correct_is_the_golden_model(folder, capsys):
    d = Descriptor.load("net.toml")
    assert run("correct net.toml raw.png -o out.png --json report.json") == 0
    golden = correct(d, read_image("raw.png"))
    np.testing.assert_array_equal(read_image("out.png"), golden.picture)
    report = json.loads((folder / "report.json").read_text())
    assert report["pixels_blank"] == golden.blank.sum() > 0
    assert report["hidden_neurons"] == d.hidden_neurons


def test_a_colour_picture_is_mosaiced_and_said_so(folder, capsys):
    assert run("correct net.toml colour.png -o out.png") == 0
    assert "colour.png is a colour picture: mosaiced as RGGB" in capsys.readouterr().err
    golden = correct(Descriptor.load("net.toml"), mosaic(read_image("colour.png"), "RGGB"))
    np.testing.assert_array_equal(read_image("out.png"), golden.picture)


@pytest.mark.longer
def test_generate_writes_the_corrector(folder, capsys):
    assert run("generate net.toml -o hw --data-width 64 --to stream --json -") == 0
    report = json.loads(capsys.readouterr().out)
    assert report["data_width"] == 64 and report["output"] == "stream"
    verilog = corrector_verilog(Descriptor.load("net.toml"),
                                planned(report, data_width=64, output="stream"))
    assert (folder / "hw" / "ncdc.v").read_text() == verilog


def planned(report, **choices):
    """The hardware of a report of generate or simulate."""
    return Hardware(cache=CacheOptions.of_bytes(report["cache_bytes"]),
                    split=report["cache_split"], strip=report["strip"], **choices)


@pytest.mark.longer
@pytest.mark.parametrize("to", ["memory", "stream"])
def test_generate_plans_the_cache_and_says_so(folder, to, capsys):
    assert run(f"generate net.toml -o hw --to {to}") == 0
    line = capsys.readouterr().out.splitlines()[0]
    assert re.fullmatch(r"cache of \d+ bytes, split \d, .*: [\d.]+ bytes read per pixel, "
                        r"[\d.]+ times the distinct bytes", line)
    assert run(f"generate net.toml -o hw --to {to} --cache-bytes 4096 --json -") == 0
    report = json.loads(capsys.readouterr().out)
    assert report["cache_bytes"] == 4096
    assert (folder / "hw" / "ncdc.v").read_text() == corrector_verilog(
        Descriptor.load("net.toml"), planned(report, output=to))


@pytest.mark.regress
def test_front_end_options_reach_the_verilog(folder, capsys):
    options = "--hidden raster --share 2 --multiplier-bits 18"
    assert run(f"generate net.toml -o hw --json r.json {options}") == 0
    report = json.loads((folder / "r.json").read_text())
    verilog = corrector_verilog(
        Descriptor.load("net.toml"), planned(report, hidden="raster", share=2, multiplier_bits=18))
    assert (folder / "hw" / "ncdc.v").read_text() == verilog
    assert run(f"simulate net.toml raw.png -o sim.png --json r.json {options}") == 0
    report = json.loads((folder / "r.json").read_text())
    assert report["pixels_different"] == 0
    assert (report["hidden"], report["share"], report["multiplier_bits"]) == ("raster", 2, 18)


@pytest.mark.regress
def test_cache_options_reach_the_verilog(folder, capsys):
    options = ("--cache-bytes 2048 --cache-pending 64 --cache-outstanding 8 --cache-split 1 "
               "--strip 0")
    assert run(f"generate net.toml -o hw {options}") == 0
    cache = CacheOptions(tiles=32, pending=64, outstanding=8)
    verilog = corrector_verilog(Descriptor.load("net.toml"), Hardware(cache=cache, split=1))
    assert options.partition(" --strip")[0] in verilog
    assert (folder / "hw" / "ncdc.v").read_text() == verilog
    assert run(f"simulate net.toml raw.png -o sim.png --json r.json {options}") == 0
    report = json.loads((folder / "r.json").read_text())
    assert report["windows_fetched"] == report["windows_fetched_expected"] > 0
    assert (report["pixels_different"], report["cache_bytes"],
            report["cache_split"]) == (0, 2048, 1)


@pytest.mark.parametrize("options,message", [
    ("--cache-pending 100", "pending is 100, a power of two from 4 to 1024 is needed"),
    ("--cache-outstanding 65", "outstanding is 65, the limits are 1 and 64"),
    ("--cache-bytes 3000", "size is 3000 bytes, a power of two from 1024 to 262144 is needed"),
    ("--cache-bytes 1024 --cache-split 3", "split is 3, the limits are 0 and 2")])
def test_rejects_a_cache_that_there_is_not(folder, options, message, capsys):
    check_rejected(folder, f"generate net.toml -o hw {options}", message, capsys)


@pytest.mark.longer
def test_simulate_multiport(folder, capsys):
    assert run("simulate net.toml raw.png -o sim.png --json r.json --fetch multiport") == 0
    report = json.loads((folder / "r.json").read_text())
    assert report["windows_fetched"] == report["windows_fetched_expected"] > 0
    assert (report["pixels_different"], report["fetch"]) == (0, "multiport")


def test_rejects_sharing_among_too_many(folder, capsys):
    check_rejected(folder, "generate net.toml -o hw --share 9", "the limit is the number of hidden",
                  capsys)


@pytest.mark.longer
@pytest.mark.parametrize("simulator", ["verilator", "icarus"])
def test_simulate(folder, simulator, capsys):
    assert run(f"simulate net.toml raw.png -o sim.png --json r.json --simulator {simulator}") == 0
    report = json.loads((folder / "r.json").read_text())
    assert (report["pixels_compared"], report["pixels_different"]) == (48 * 40, 0)
    assert report["windows_fetched"] == report["windows_fetched_expected"] > 0
    assert report["simulator"] == simulator and report["fetch"] == "cache"
    golden = correct(Descriptor.load("net.toml"), read_image("raw.png"))
    np.testing.assert_array_equal(read_image("sim.png"), golden.picture)


@pytest.mark.longer
def test_simulate_names_the_first_difference(folder, capsys, monkeypatch):
    """A golden model off by one in one pixel must be found, named, and give status 1."""
    def wrong(descriptor, raw, **options):
        result = correct(descriptor, raw, **options)
        result.picture[7, 30, 1] ^= 1
        return result

    monkeypatch.setattr("ncdc_sim.system.corrector.correct", wrong)
    assert run("simulate net.toml raw.png -o sim.png") == 1
    err = capsys.readouterr().err
    assert "1 pixels differ from the golden model, the first at column 30, row 7" in err


@pytest.mark.parametrize("command", cli.COMMANDS)
def test_help_has_an_example(command, capsys):
    with pytest.raises(SystemExit) as end:
        cli.main([command, "--help"])
    out = capsys.readouterr().out
    assert end.value.code == 0 and f"example: ncdc {command}" in " ".join(out.split())


@pytest.mark.longer
def test_a_command_imports_what_it_needs_alone():
    """Matplotlib and SciPy take half a second each to import."""
    code = ("import sys; from ncdc.cli import parser\n"
            "for name in ('correct', 'calibrate', 'train', 'generate', 'plan'):\n"
            "    parser(name); print(name, *sorted({'matplotlib', 'scipy'} & {*sys.modules}))")
    done = subprocess.run([sys.executable, "-c", code], check=True, text=True,
                          stdout=subprocess.PIPE)
    assert done.stdout.split() == ["correct", "calibrate", "train", "generate", "plan"]


def test_a_command_that_does_not_exist_is_answered_with_all_that_do(capsys):
    assert run("corect net.toml raw.png") == 2
    error = capsys.readouterr().err
    assert all(command in error for command in ("corect", *cli.COMMANDS))


def test_written_files_replace_whole(folder):
    """No temporary file is left next to the output."""
    assert run("correct net.toml raw.png -o out.png") == 0
    assert not list(folder.glob(".ncdc-*"))
    assert cv2.imread("out.png") is not None


@pytest.mark.parametrize("command,groups", [
    ("train", ["where the pairs come from", "network and training", "picture", "hardware"]),
    ("generate", ["hardware", "what is written"]),
    ("simulate", ["hardware", "simulation", "low latency", "a running camera", "colour"])])
def test_long_help_has_groups(command, groups, capsys):
    """No option of the command is left in the general group but those of its files."""
    with pytest.raises(SystemExit):
        cli.main([command, "--help"])
    out = capsys.readouterr().out
    offsets = [out.index(f"\n{group}:\n") for group in groups]
    assert offsets == sorted(offsets)
    general = re.search(r"\noptions:\n(.*?)\n\n", out, re.DOTALL)[1]
    named = set(re.findall(r"^  (?:-\w[ \w]*, )?(--[\w-]+)", general, re.MULTILINE))
    assert named <= {"--help", "--output", "--json"}


def test_train_without_neurons_trains_eight(capsys):
    assert cli.parser("train").parse_args(["train", "points.json"]).neurons == 8
