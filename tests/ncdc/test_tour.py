"""The tutorial's tour: every line runs as it is printed, in an empty folder."""

import re
import shlex
from pathlib import Path

import cv2
import pytest

from cameras import barrel_descriptor
from ncdc.cli import main
from ncdc.cli.board_design import planner
from ncdc_bench.figures.tutorial_figures import PICTURES, draw
from ncdc_boards.board import Request
from ncdc_boards.catalogue import board_for
from ncdc_model.example import example_camera, target_photo
from ncdc_model.images import write_image

DOCS = Path(__file__).resolve().parents[2] / "docs"
TUTORIAL = (DOCS / "start" / "tutorial.md").read_text()
PHOTO = "demo/photo.raw.png"        # of `ncdc demo`, which test_demo.py runs
FILE = re.compile(r"(?:[\w.]+/)?\w[\w.]*\.(?:png|json|toml|v)")


def tour():
    """(arguments, comment) of each line of the tour."""
    [block] = re.findall(r"## Run the steps\n\n((?:    ncdc .*\n)+)", TUTORIAL)
    return [(shlex.split(line.partition("#")[0])[1:], line.partition("#")[2].strip())
            for line in block.splitlines()]


def outputs(arguments, comment):
    """Files and folders that a line writes: of its option -o, and those its comment names."""
    named = [arguments[arguments.index("-o") + 1]] if "-o" in arguments else []
    return named + FILE.findall(comment) * (arguments[0] != "generate")


def test_a_line_reads_what_an_earlier_one_wrote():
    there = {PHOTO}
    lines = tour()
    assert len(lines) == 9
    for arguments, comment in lines:
        written = outputs(arguments, comment)
        assert set(filter(FILE.fullmatch, arguments)) - set(written) <= there, arguments
        there |= set(written)


def test_the_boards_carry_the_tour_s_picture():
    """What `ncdc build` checks first, without the seconds that the Verilog takes."""
    train, build = (next(line for line, _ in tour() if line[0] == name)
                    for name in ("train", "build"))
    size = tuple(map(int, train[train.index("--size") + 1].split("x")))
    descriptor = barrel_descriptor(size, (640, 480), hidden_neurons=2)
    board = board_for("build", build[build.index("--board") + 1])
    rates = board.rates(board.design([("net.toml", descriptor)], Request(), planner()))
    # As often as the sensor sends it.
    assert rates["corrected_frames_per_second"] == rates["sensor_frames_per_second"] > 20


ROW = re.compile(r"^ +((?:training|held out|beyond points|region|frame) +(?:float|fixed) .*)$",
                 re.MULTILINE)


def test_the_pages_agree_on_the_demo_s_figures():
    """With the commands test_quoted_output.py compares them, in minutes."""
    demo = TUTORIAL.partition("[1/6]")[2].partition("[6/6]")[0]
    page = (DOCS / "reference" / "commands.md").read_text()
    sections = {text.partition("\n")[0]: text for text in page.split("\n## ")}
    trained = sections["train"].partition("-o net.toml")[2].partition("The paper")[0]
    shown = ROW.findall(sections["demo"]) + ROW.findall(trained)
    assert len(shown) == 2 + 8 and set(shown) == set(ROW.findall(demo))


@pytest.mark.many_clocks
@pytest.mark.regress
def test_every_line_of_the_tour_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_image(PHOTO, target_photo(example_camera()))
    for arguments, comment in tour():
        assert main(arguments) == 0, (arguments, capsys.readouterr().err)
        for name in outputs(arguments, comment):
            assert Path(name).exists(), (arguments, name)
    assert "307200 pixels compared, 0 differ" in capsys.readouterr().out
    assert Path("hardware/ncdc.v").stat().st_size and Path("project/build.sh").is_file()


@pytest.mark.regress
def test_the_tutorial_s_pictures_are_what_its_commands_make(tmp_path):
    draw(tmp_path)
    for name in PICTURES.values():
        made, shown = (cv2.imread(str(folder / name)) for folder in (tmp_path, DOCS / "figures"))
        assert made.shape == shown.shape
        assert cv2.absdiff(made, shown).mean() < 1          # grey levels: JPEG libraries differ
