"""What the pages say that a command prints, on the example camera, is what it prints."""

import re
import shlex
from pathlib import Path

import pytest

from ncdc.cli import main
from ncdc_model.example import example_camera, scene_photo, target_photo
from ncdc_model.images import write_image

ROOT = Path(__file__).resolve().parents[2]
PROGRESS = re.compile(r"[\w ]+: +\d+ %")
QUICK = "calibrate", "train", "evaluate", "correct", "export", "plan"


def quoted(page):
    """(arguments, lines of output) of every quoted command that is quick and prints something."""
    found = []
    for line in (ROOT / page).read_text().splitlines():
        if line.startswith("    $ ncdc "):
            found.append((shlex.split(line.removeprefix("    $ ncdc ")), []))
        elif line.startswith("    ") and found:
            found[-1][1].append(line[4:])
        elif found:
            found.append(([""], []))
    return [(command, lines) for command, lines in found if lines and command[0] in QUICK]


def missing(quoted_lines, printed):
    """Quoted lines that do not follow one another in ``printed``; "..." stands for any lines."""
    position, jump = 0, True
    for line in quoted_lines:
        if line.strip() == "...":
            jump = True
            continue
        rest = printed[position:] if jump else printed[position:position + 1]
        if line not in rest:
            return [line]
        position, jump = position + rest.index(line) + 1, False
    return []


def in_either_order(out, err):
    """Lines of both outputs but for progress: on a terminal either may come first."""
    return [[line for line in text.splitlines() if not PROGRESS.match(line)]
            for text in (out + err, err + out)]


def test_a_line_that_is_not_printed_is_found():
    printed = ["a", "b", "c"]
    assert missing(["a", "b"], printed) == missing(["a", "...", "c"], printed) == []
    assert missing(["a", "c"], printed) == ["c"]
    assert missing(["b", "a"], printed) == ["a"]


@pytest.mark.many_clocks
@pytest.mark.regress
def test_quoted_outputs_are_those_of_the_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    camera = example_camera()
    camera.save("camera.toml")
    write_image("photo.raw.png", target_photo(camera))
    write_image("distorted.raw.png", scene_photo(camera))
    checked, wrong = set(), {}
    for page in ("docs/reference/commands.md", "docs/explanation/planner.md"):
        for command, lines in quoted(page):
            main(command)
            printed = in_either_order(*capsys.readouterr())
            checked.add(command[0])
            if all(lost := [missing(lines, one) for one in printed]):
                wrong[" ".join(command)] = lost, printed[0]
    assert checked == set(QUICK) and not wrong


@pytest.mark.many_clocks
@pytest.mark.regress
def test_the_demos_output_in_the_tutorial_is_the_commands(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    page = [line[4:] for line in (ROOT / "docs/start/tutorial.md").read_text().splitlines()]
    start = page.index("[1/6] photo of a page of dots, through the example camera")
    lines = page[start:page.index("look at demo/report.html") + 1]
    assert main(["demo", "-o", "demo"]) == 0
    printed = in_either_order(*capsys.readouterr())
    assert [] in [missing(lines, one) for one in printed], printed

    verilog = Path("demo/ncdc.v").read_text()
    modules = len(re.findall("^module ", verilog, re.MULTILINE))
    size = f"{len(verilog.splitlines()):,} lines in {modules} modules"
    page = (ROOT / "docs/reference/verilog.md").read_text()
    assert size in re.sub("<!--.*?-->", "", page)       # the names of figures
